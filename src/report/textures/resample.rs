//! A map at another size: what a viewer shows of a draft, and the mean of finer texels.

use super::difference::Texels;
use crate::base::MapKind;

/// A map drawn `times` as large, as a viewer does it: linear between texel centres, through the seams; ids are those of
/// the nearest texel, normals are made unit vectors again.
pub(super) fn enlarged(map: &Texels, width: usize, height: usize) -> Texels {
    let (w, h) = (map.width, map.len() / map.width);
    let place = |i: usize, to: usize, from: usize| {
        let t = (i as f64 + 0.5) * from as f64 / to as f64 - 0.5;
        let low = t.floor();
        let wrap = |i: f64| (i as i64).rem_euclid(from as i64) as usize;
        (wrap(low), wrap(low + 1.0), t - low)
    };
    let columns: Vec<_> = (0..width).map(|x| place(x, width, w)).collect();
    let nearest = map.kind == MapKind::ScaleId;
    let channel = |data: &Vec<f64>| {
        let mut out = Vec::with_capacity(width * height);
        for y in 0..height {
            let (y0, y1, ty) = place(y, height, h);
            for &(x0, x1, tx) in &columns {
                let across = |y: usize| data[y * w + x0] + (data[y * w + x1] - data[y * w + x0]) * tx;
                out.push(if nearest {
                    data[if ty < 0.5 { y0 } else { y1 } * w + if tx < 0.5 { x0 } else { x1 }]
                } else {
                    across(y0) + (across(y1) - across(y0)) * ty
                });
            }
        }
        out
    };
    unit(Texels { kind: map.kind, width, channels: map.channels.iter().map(channel).collect() })
}

/// The mean of every `times` x `times` texels; what is left at the right and below is dropped. Ids are those of the first
/// texel, normals are made unit vectors again.
pub(super) fn averaged(map: &Texels, times: usize) -> Texels {
    let (w, h) = (map.width, map.len() / map.width);
    let (width, height) = (w / times, h / times);
    let channel = |data: &Vec<f64>| {
        let block = |i: usize| {
            let first = i / width * times * w + i % width * times;
            if map.kind == MapKind::ScaleId {
                return data[first];
            }
            let rows = (0..times).map(|y| data[first + y * w..][..times].iter().sum::<f64>());
            rows.sum::<f64>() / (times * times) as f64
        };
        (0..width * height).map(block).collect()
    };
    unit(Texels { kind: map.kind, width, channels: map.channels.iter().map(channel).collect() })
}

fn unit(mut map: Texels) -> Texels {
    if let (MapKind::Normal, [x, y, z]) = (map.kind, &mut map.channels[..]) {
        for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
            let length = (*x * *x + *y * *y + *z * *z).sqrt();
            if length > 0.0 {
                (*x, *y, *z) = (*x / length, *y / length, *z / length);
            }
        }
    }
    map
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waves(w: usize, h: usize) -> Texels {
        let wave = |i: usize| {
            let (u, v) = ((i % w) as f64 + 0.5, (i / w) as f64 + 0.5);
            (std::f64::consts::TAU * u / w as f64).sin() + (std::f64::consts::TAU * v / h as f64).cos()
        };
        Texels { kind: MapKind::Height, width: w, channels: vec![(0..w * h).map(wave).collect()] }
    }

    /// Linear interpolation of a wave of n texels is at most (2 pi / n)^2 / 8 off, in each direction.
    #[test]
    fn a_wave_enlarged_is_the_wave_and_so_is_its_mean() {
        let (small, large) = (waves(32, 16), waves(128, 64));
        let far = |a: &Texels, b: &Texels| {
            a.channels[0].iter().zip(&b.channels[0]).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()))
        };
        let bound = |n: f64| (std::f64::consts::TAU / n).powi(2) / 8.0;
        let found = far(&enlarged(&small, 128, 64), &large);
        assert!(found < bound(32.0) + bound(16.0) && found > 0.5 * bound(16.0), "{found}");
        // The mean of n samples a texel of 1/32 of a wave: sinc.
        assert!(far(&averaged(&large, 4), &small) < 0.03);
        assert!(far(&averaged(&large, 4), &large) > 0.1);
        assert_eq!(far(&enlarged(&small, 32, 16), &small), 0.0);
    }

    #[test]
    fn ids_stay_ids_and_normals_unit_vectors() {
        let ids = Texels { kind: MapKind::ScaleId, width: 2, channels: vec![vec![3.0, 7.0, 3.0, 9.0]] };
        assert!(enlarged(&ids, 6, 6).channels[0].iter().all(|v| [3.0, 7.0, 9.0].contains(v)));
        assert_eq!(averaged(&ids, 2).channels[0], [3.0]);
        let normals = Texels {
            kind: MapKind::Normal,
            width: 2,
            channels: vec![vec![0.6, -0.6], vec![0.0; 2], vec![0.8; 2]],
        };
        let large = enlarged(&normals, 8, 1);
        for i in 0..8 {
            let square: f64 = large.channels.iter().map(|c| c[i] * c[i]).sum();
            assert!((square - 1.0).abs() < 1e-12);
        }
    }
}
