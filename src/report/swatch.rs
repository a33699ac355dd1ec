//! The colour of a film against thickness and angle: a field of colours, and red, green and blue below it.

use std::fmt::Write as _;

use super::html::escape;
use super::plot::{Axis, Plot, STYLE, Series};
use crate::base::{LinearRgb, Srgb8};
use crate::optics::{Film, FilmColor, FilmError};

/// Colours of the field across and up.
const CELLS: (u32, u32) = (120, 36);
/// Greatest angle of the field, degrees: beyond it all is white.
const MAX_ANGLE_DEG: f64 = 85.0;
/// The field is shown so many times as bright: a film on skin reflects a tenth of the light.
const BRIGHTER: f64 = 4.0;
/// Rectangle of the field: left, top, right, bottom.
const FIELD: (f64, f64, f64, f64) = (72.0, 44.0, 736.0, 300.0);

/// A picture of films of these indices, 0 to `end_nm` thick; the curves are those at `angle_deg`.
pub fn film(
    colors: &FilmColor<f64>,
    [n0, n1, n2]: [f64; 3],
    end_nm: f64,
    angle_deg: f64,
) -> Result<String, FilmError> {
    let (left, top, right, bottom) = FIELD;
    let title = format!("Colour of a film: {n0}/{n1}/{n2}, {BRIGHTER} times as bright");
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 760 800\" width=\"760\" role=\"img\" aria-label=\"{0}\">\n\
         <style>{STYLE}</style>\n<text class=\"t\" x=\"{left}\" y=\"20\">{0}</text>\n",
        escape(&title)
    );
    let (across, up) = (f64::from(CELLS.0), f64::from(CELLS.1));
    let (width, height) = ((right - left) / across, (bottom - top) / up);
    for j in 0..CELLS.1 {
        let cosine = super::film::cosine(MAX_ANGLE_DEG * (f64::from(j) + 0.5) / up);
        for i in 0..CELLS.0 {
            let film = Film::new(n0, n1, n2, end_nm * (f64::from(i) + 0.5) / across)?;
            let rgb = colors.color(&film, cosine).map(|c| (c * BRIGHTER) as f32);
            let (x, y) = (left + width * f64::from(i), bottom - height * f64::from(j + 1));
            let color = Srgb8::from(LinearRgb(rgb));
            // Strings take text without fail. A little wider than a cell: no seams.
            let _ = writeln!(
                svg,
                "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{color}\"/>",
                width + 0.4,
                height + 0.4
            );
        }
    }
    for degrees in [0.0, 15.0, 30.0, 45.0, 60.0, 75.0] {
        let y = bottom - (bottom - top) * degrees / MAX_ANGLE_DEG;
        let _ = writeln!(
            svg,
            "<text class=\"l\" text-anchor=\"end\" x=\"{:.1}\" y=\"{:.1}\">{degrees}</text>",
            left - 8.0,
            y + 4.0
        );
    }
    let _ = writeln!(
        svg,
        "<text class=\"l\" text-anchor=\"middle\" transform=\"translate(16 {:.1}) rotate(-90)\">angle of incidence, degrees</text>",
        (top + bottom) * 0.5
    );
    let mut plot = Plot::new(
        format!("Red, green and blue at {angle_deg} degrees"),
        Axis::linear("thickness, nm"),
        Axis::linear("reflected, linear RGB"),
    );
    let films: Vec<(f64, [f64; 3])> = (0..=400)
        .map(|i| end_nm * f64::from(i) / 400.0)
        .map(|d| Ok((d, colors.color(&Film::new(n0, n1, n2, d)?, super::film::cosine(angle_deg)))))
        .collect::<Result<_, _>>()?;
    for (c, (name, color)) in [("red", 3), ("green", 2), ("blue", 0)].into_iter().enumerate() {
        plot.series.push(Series::line(name, color, films.iter().map(|(d, rgb)| (*d, rgb[c])).collect()));
    }
    svg += &plot.drawn((0.0, 320.0, 760.0, 470.0));
    svg += "</svg>\n";
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Method;

    #[test]
    fn a_picture_has_the_colours_and_the_words() {
        let colors = FilmColor::new(Method::Series(3));
        let svg = film(&colors, [1.0, 1.55, 2.0], 1000.0, 30.0).expect("a film");
        assert_eq!(svg.matches("<rect").count(), (CELLS.0 * CELLS.1) as usize);
        for part in ["at 30 degrees", "thickness, nm", "angle of incidence", "1/1.55/2"] {
            assert!(svg.contains(part), "{part}");
        }
        assert!(film(&colors, [1.0, 0.0, 2.0], 1000.0, 30.0).is_err());
    }
}
