//! Pictures of the snake, drawn in a thread of their own: coarse while the camera moves; the newest request wins.

use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::Instant;

use rayon::prelude::*;

use super::latest::Latest;
use super::orbit::Orbit;
use super::stage::Stage;
use crate::base::LinearRgb;
use crate::maps::TextureSet;
use crate::preview::{Development, Gpu, Options, PreviewError, Renderer};
use crate::scene::spec::{MIDDLE_GREY, MeteringSpec};
use crate::scene::{Inputs, Scene, SkinMaps, bloom::bloom, tone::ToneMap};

/// Longest frame while the camera moves, ms: fewer pixels are drawn rather than that.
const FLUENT_MS: f64 = 60.0;

/// Least share of the columns that is drawn while the camera moves.
const COARSEST: f64 = 0.25;

/// What is wanted.
#[derive(Clone, Debug)]
pub(super) struct PictureRequest {
    /// Where the snake lies, and in which light.
    pub(super) stage: Arc<Stage>,
    /// What it wears: the one kept for comparison, and the one at work.
    pub(super) skins: [Option<Arc<TextureSet>>; 2],
    /// From where; the scene's own camera if `None`.
    pub(super) orbit: Option<Orbit>,
    /// Pixels: columns and rows.
    pub(super) size: [usize; 2],
    /// Whether another request comes soon: a quick picture will do.
    pub(super) moving: bool,
    /// The tone curve.
    pub(super) tone: ToneMap,
    /// Added to the scene's exposure.
    pub(super) exposure_ev: f32,
}

impl PictureRequest {
    /// Whether both want the same picture.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        let skins = |(a, b): (&Option<Arc<TextureSet>>, &Option<Arc<TextureSet>>)| match (a, b) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        };
        Arc::ptr_eq(&self.stage, &other.stage)
            && self.skins.iter().zip(&other.skins).all(skins)
            && (self.orbit, self.size, self.moving) == (other.orbit, other.size, other.moving)
            && (self.tone, self.exposure_ev) == (other.tone, other.exposure_ev)
    }
}

/// What came of a request.
#[derive(Debug)]
pub(super) enum PictureNews {
    /// Pictures.
    Drawn(Drawn),
    /// None: why.
    Failed(String),
}

/// Pictures of one view.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    /// As the request's skins: sRGB, row by row from the top.
    pub(super) pixels: [Option<Vec<u8>>; 2],
    /// Columns and rows; fewer than asked for while the camera moves.
    pub(super) size: [usize; 2],
    /// From where.
    pub(super) orbit: Orbit,
    /// How long drawing them took, ms.
    pub(super) milliseconds: f64,
    /// How long laying skins on the subject took before, ms.
    pub(super) dress_ms: f64,
}

/// A skin on its subject, ready to be drawn.
struct Worn<'g> {
    stage: Arc<Stage>,
    set: Arc<TextureSet>,
    renderer: Renderer<'g>,
    own: Orbit,
    /// Measured.
    ms_per_pixel: f64,
    /// The last picture: another tone curve needs no other one.
    last: Option<(Orbit, [usize; 2])>,
}

/// Serve requests until nobody asks any more. `wake` is called after each news.
pub(super) fn serve(
    requests: &Latest<PictureRequest>,
    mut gpu: Gpu,
    news: &Sender<PictureNews>,
    wake: &dyn Fn(),
) {
    // A device that was lost does not come back: another one is asked for, once for each time.
    while let Some(error) = with_device(requests, &gpu, news, wake) {
        let again = Gpu::new(None);
        let told = again.as_ref().err().unwrap_or(&error).to_string();
        let _ = news.send(PictureNews::Failed(told));
        wake();
        match again {
            Ok(new) => gpu = new,
            Err(_) => return,
        }
    }
}

/// Serve requests by one device: `None` once nobody asks any more, or why the device is of no more use.
fn with_device(
    requests: &Latest<PictureRequest>,
    gpu: &Gpu,
    news: &Sender<PictureNews>,
    wake: &dyn Fn(),
) -> Option<PreviewError> {
    let mut worn: [Option<Worn<'_>>; 2] = [None, None];
    while let Some(request) = requests.take() {
        let told = match draw(&request, gpu, &mut worn) {
            Ok(Some(drawn)) => PictureNews::Drawn(drawn),
            Ok(None) => continue,
            Err(Fault::Device(error @ PreviewError::Lost(_))) => return Some(error),
            Err(fault) => {
                // What is on the device may be what there was no room for.
                worn = [None, None];
                PictureNews::Failed(fault.to_string())
            }
        };
        // Who does not listen any more closes the requests, too.
        let _ = news.send(told);
        wake();
    }
    None
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
enum Fault {
    #[error(transparent)]
    Device(#[from] PreviewError),
    #[error(transparent)]
    Scene(#[from] crate::scene::SceneError),
}

/// `None` where there is no skin.
fn draw<'g>(
    request: &PictureRequest,
    gpu: &'g Gpu,
    worn: &mut [Option<Worn<'g>>; 2],
) -> Result<Option<Drawn>, Fault> {
    let start = Instant::now();
    let is = |worn: &Option<Worn<'_>>, skin: &Option<Arc<TextureSet>>| match (worn, skin) {
        (Some(worn), Some(set)) => Arc::ptr_eq(set, &worn.set) && Arc::ptr_eq(&worn.stage, &request.stage),
        _ => false,
    };
    // What is kept was worn just before.
    let [kept, now] = worn;
    if !is(kept, &request.skins[0]) && is(now, &request.skins[0]) {
        std::mem::swap(kept, now);
    }
    for (worn, skin) in worn.iter_mut().zip(&request.skins) {
        if !is(worn, skin) {
            match (worn.as_mut().filter(|w| Arc::ptr_eq(&w.stage, &request.stage)), skin) {
                // While a slider is dragged: only its maps are new.
                (Some(worn), Some(set)) if worn.fits(set) => worn.wear(set)?,
                _ => {
                    // The old one's textures are given back before the new ones are made.
                    *worn = None;
                    *worn = skin.as_ref().map(|set| Worn::new(gpu, &request.stage, set)).transpose()?;
                }
            }
        }
    }
    let dress_ms = start.elapsed().as_secs_f64() * 1e3;
    let Some(first) = worn.iter().flatten().next_back() else { return Ok(None) };
    let orbit = request.orbit.unwrap_or(first.own);
    let slowest = worn.iter().flatten().map(|w| w.ms_per_pixel).sum();
    let size = if request.moving { quick(request.size, slowest) } else { request.size };
    let mut drawn = Drawn { pixels: [None, None], size, orbit, milliseconds: 0.0, dress_ms };
    for (pixels, worn) in drawn.pixels.iter_mut().zip(worn.iter_mut()) {
        let Some(worn) = worn else { continue };
        drawn.milliseconds += worn.draw(&orbit, size)?;
        *pixels = worn.shown(request)?;
    }
    Ok(Some(drawn))
}

/// So many columns and rows that a picture takes no longer than [`FLUENT_MS`].
fn quick([width, height]: [usize; 2], ms_per_pixel: f64) -> [usize; 2] {
    let expected = ms_per_pixel * (width * height) as f64;
    let share = if expected > FLUENT_MS { (FLUENT_MS / expected).sqrt().max(COARSEST) } else { 1.0 };
    [width, height].map(|n| ((n as f64 * share) as usize).max(1))
}

/// What the scene of a stage is made of.
fn inputs(stage: &Stage, set: &TextureSet) -> Inputs {
    Inputs {
        maps: Some(Arc::new(SkinMaps::new(set, stage.spec.material.texel()))),
        optics: set.optics,
        mesh: None,
        picture: stage.picture.clone(),
        size_mm: [set.domain.girth_mm, set.domain.length_mm],
    }
}

impl<'g> Worn<'g> {
    fn new(gpu: &'g Gpu, stage: &Arc<Stage>, set: &Arc<TextureSet>) -> Result<Self, Fault> {
        let scene = Scene::build(&stage.spec, &inputs(stage, set))?;
        let options = Options { samples: 1, ..Options::of(gpu) };
        Ok(Self {
            renderer: Renderer::new(gpu, &scene, &options)?,
            own: Orbit::of(&scene.camera),
            stage: stage.clone(),
            set: set.clone(),
            ms_per_pixel: 0.0,
            last: None,
        })
    }

    /// Whether a skin lies on the mesh that is there: of the same size, on one that no map moves.
    fn fits(&self, set: &TextureSet) -> bool {
        let size = |set: &TextureSet| [set.domain.girth_mm, set.domain.length_mm];
        self.stage.spec.subject.displacement == 0.0 && size(set) == size(&self.set)
    }

    /// Lay another skin on the subject.
    fn wear(&mut self, set: &Arc<TextureSet>) -> Result<(), Fault> {
        let skin = crate::scene::skin(&self.stage.spec, &inputs(&self.stage, set));
        self.renderer.wear(0, &skin)?;
        (self.set, self.last) = (set.clone(), None);
        Ok(())
    }

    /// Draw it, unless that is what was drawn last; returns the milliseconds.
    fn draw(&mut self, orbit: &Orbit, size: [usize; 2]) -> Result<f64, PreviewError> {
        if self.last.as_ref().is_some_and(|(o, s)| o == orbit && *s == size) {
            return Ok(0.0);
        }
        let start = Instant::now();
        self.renderer.keep(&orbit.camera(), size)?;
        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
        self.ms_per_pixel = milliseconds / (size[0] * size[1]) as f64;
        self.last = Some((*orbit, size));
        Ok(milliseconds)
    }

    /// The last picture as a screen shows it: bloom, exposure and tone curve are made where it was drawn.
    fn shown(&mut self, request: &PictureRequest) -> Result<Option<Vec<u8>>, PreviewError> {
        let Some((orbit, size)) = self.last else { return Ok(None) };
        let render = &self.stage.spec.render;
        let mean = match render.metering {
            MeteringSpec::Manual => None,
            MeteringSpec::Average => Some(MIDDLE_GREY),
            MeteringSpec::Highlights => return self.by_highlights(request, &orbit, size).map(Some),
        };
        let exposure_ev = render.exposure_ev + request.exposure_ev;
        let development = Development { bloom: render.bloom, exposure_ev, mean, tone: request.tone };
        let pixels = self.renderer.develop(&development)?;
        Ok(pixels.map(|p| p.as_chunks().0.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect()))
    }

    /// The same where a share of the pixels is to be told, which takes all of them in one place.
    fn by_highlights(
        &mut self,
        request: &PictureRequest,
        orbit: &Orbit,
        size: [usize; 2],
    ) -> Result<Vec<u8>, PreviewError> {
        let mut texels = self.renderer.render(&orbit.camera(), size)?.texels;
        let render = &self.stage.spec.render;
        bloom(&mut texels, size[0], render.bloom);
        let exposure_ev = render.exposure(&texels) + request.exposure_ev;
        let shown =
            |c: &[f32; 3]| request.tone.encode(LinearRgb(*c), exposure_ev).map(|v| (v * 255.0 + 0.5) as u8);
        let pixels: Vec<[u8; 3]> = texels.par_iter().with_min_len(4096).map(shown).collect();
        Ok(pixels.into_flattened())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_pixels_are_drawn_where_a_frame_would_take_long() {
        assert_eq!(quick([1000, 500], 0.0), [1000, 500], "nothing was measured yet");
        assert_eq!(quick([1000, 500], 1e-4), [1000, 500], "50 ms");
        assert_eq!(quick([1000, 500], 4.8e-4), [500, 250], "240 ms");
        assert_eq!(quick([1000, 500], 1.0), [250, 125]);
        assert_eq!(quick([1, 1], 1e9), [1, 1]);
    }
}
