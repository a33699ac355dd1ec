// The exposure is what is asked for.

fn metered() -> f32 {
    return 0.0;
}
