//! An adapter and its device, without a window.

use std::sync::{Arc, Mutex, PoisonError};

use wgpu::{Backends, DeviceType, Features, PollType, PowerPreference};

use super::PreviewError;

/// A device to draw with. What goes wrong on it is kept, and told by [`Gpu::check`].
#[derive(Debug)]
pub struct Gpu {
    /// Makes buffers, textures and pipelines.
    pub device: wgpu::Device,
    /// Takes commands.
    pub queue: wgpu::Queue,
    /// What the adapter is.
    pub info: wgpu::AdapterInfo,
    fault: Arc<Mutex<Option<PreviewError>>>,
}

/// Used where the adapter has them; nothing depends on them.
const WANTED: Features = Features::TIMESTAMP_QUERY;

impl Gpu {
    /// The fastest adapter of these backends; of all unless given, or of those that the variable `WGPU_BACKEND` names.
    ///
    /// The adapters of a machine's own interface (Vulkan, Metal, Direct3D) come before those of OpenGL. Software adapters
    /// such as Mesa's lavapipe are taken where there is no other.
    ///
    /// # Errors
    /// If there is no adapter, or it gives no device.
    pub fn new(backends: Option<Backends>) -> Result<Self, PreviewError> {
        let backends = backends.or_else(Backends::from_env).unwrap_or(Backends::all());
        let (first, then) = (backends & Backends::PRIMARY, backends - Backends::PRIMARY);
        match Self::of(first) {
            Err(PreviewError::NoAdapter(reason)) if !then.is_empty() => {
                Self::of(then).map_err(|error| match error {
                    PreviewError::NoAdapter(also) => PreviewError::NoAdapter(format!("{reason}; {also}")),
                    other => other,
                })
            }
            done => done,
        }
    }

    fn of(backends: Backends) -> Result<Self, PreviewError> {
        let mut about = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        about.backends = backends;
        let options = wgpu::RequestAdapterOptions {
            power_preference: PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = pollster::block_on(wgpu::Instance::new(about).request_adapter(&options))
            .map_err(|e| PreviewError::NoAdapter(without_absent(&one_line(&e))))?;
        let info = adapter.get_info();
        let asked = wgpu::DeviceDescriptor {
            label: Some("ophidian"),
            required_features: adapter.features() & WANTED,
            // All that it has: pictures and maps are as large as they are.
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&asked))
            .map_err(|e| PreviewError::NoDevice { adapter: info.name.clone(), reason: one_line(&e) })?;
        let gpu = Self { device, queue, info, fault: Arc::default() };
        gpu.keep_faults();
        Ok(gpu)
    }

    /// Without handlers of ours, wgpu panics.
    fn keep_faults(&self) {
        let kept = self.fault.clone();
        self.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let text = one_line(&error);
            keep(
                &kept,
                match error {
                    wgpu::Error::OutOfMemory { .. } => PreviewError::OutOfMemory(text),
                    _ => PreviewError::Refused(text),
                },
            );
        }));
        let kept = self.fault.clone();
        self.device.set_device_lost_callback(move |reason, text| {
            // Ours to end it, and no fault then.
            if reason != wgpu::DeviceLostReason::Destroyed {
                keep(&kept, PreviewError::Lost(text));
            }
        });
    }

    /// Whether the adapter is a program on the CPU.
    pub fn is_software(&self) -> bool {
        self.info.device_type == DeviceType::Cpu
    }

    /// Whether the adapter can tell how long passes take.
    pub fn has_timestamps(&self) -> bool {
        self.device.features().contains(Features::TIMESTAMP_QUERY)
    }

    /// Refuse what is larger than the adapter holds.
    ///
    /// # Errors
    /// If `needed` is above `most`.
    pub fn fits(&self, what: &'static str, needed: u64, most: u64) -> Result<(), PreviewError> {
        if needed > most { Err(PreviewError::TooLarge { what, needed, most }) } else { Ok(()) }
    }

    /// The first fault that came up since the last call.
    ///
    /// # Errors
    /// That fault.
    pub fn check(&self) -> Result<(), PreviewError> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }

    /// Wait until everything submitted is done.
    ///
    /// # Errors
    /// If the device was lost, or something failed on it.
    pub fn wait(&self) -> Result<(), PreviewError> {
        let polled = self.device.poll(PollType::wait_indefinitely());
        self.check()?;
        polled.map(|_| ()).map_err(|e| PreviewError::Lost(one_line(&e)))
    }
}

/// The first fault is the cause, later ones its consequences.
fn keep(kept: &Mutex<Option<PreviewError>>, fault: PreviewError) {
    kept.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(fault);
}

/// The message without interfaces that were not asked or are not in this build.
fn without_absent(message: &str) -> String {
    let told = |part: &&str| !part.contains("not requested") && !part.contains("not compiled in");
    let parts = message.rsplit(';').next().unwrap_or(message).split(',').map(str::trim).filter(told);
    let parts: Vec<&str> = parts.collect();
    if parts.is_empty() { message.to_owned() } else { parts.join(", ") }
}

/// A driver's message on one line.
fn one_line(error: &impl std::fmt::Display) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A device for tests; `None`, and a line that says so, where the machine has none. With OPHIDIAN_REQUIRE_GPU=1 that
    /// fails.
    pub(in super::super) fn gpu() -> Option<Gpu> {
        match Gpu::new(None) {
            Ok(gpu) => Some(gpu),
            Err(error) => {
                assert!(std::env::var_os("OPHIDIAN_REQUIRE_GPU").is_none_or(|v| v != "1"), "{error}");
                println!("SKIPPED: {error}");
                None
            }
        }
    }

    #[test]
    fn no_backend_is_an_error_of_one_line() {
        let error = Gpu::new(Some(Backends::empty())).expect_err("there is none");
        assert!(matches!(error, PreviewError::NoAdapter(_)), "{error}");
        assert!(!error.to_string().contains('\n'), "{error}");
    }

    #[test]
    fn faults_are_kept_and_told_once() {
        let Some(gpu) = gpu() else { return };
        assert_eq!(gpu.check(), Ok(()));
        let side = gpu.device.limits().max_texture_dimension_2d + 1;
        let size = wgpu::Extent3d { width: side, height: 1, depth_or_array_layers: 1 };
        let texture = wgpu::TextureDescriptor {
            label: Some("too wide"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let _ = gpu.device.create_texture(&texture);
        let error = gpu.wait().expect_err("no adapter holds it");
        assert!(matches!(&error, PreviewError::Refused(text) if text.contains("too wide")), "{error}");
        assert_eq!(gpu.wait(), Ok(()));
    }
}
