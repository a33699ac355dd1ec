//! Pictures on a page: side by side, as PNG within SVG, so that a page needs no other file.

use std::fmt::Write as _;

use super::html::escape;
use super::plot::STYLE;
use crate::base::Srgb8;

/// Room between pictures, and for a line of words above them.
const GAP: usize = 8;
const LINE: usize = 20;

/// Rows of pictures, all of one size (columns, rows), each with words above it. `wide` is the width of a picture on the page.
///
/// # Errors
/// If a picture has another number of pixels than its size says.
pub fn rows(
    size: [usize; 2],
    wide: usize,
    rows: &[Vec<(String, Vec<Srgb8>)>],
) -> Result<String, png::EncodingError> {
    let high = wide * size[1] / size[0].max(1);
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let (width, height) = (columns * (wide + GAP), rows.len() * (high + LINE + GAP));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" role=\"img\">\n\
         <style>{STYLE}</style>\n"
    );
    for (j, row) in rows.iter().enumerate() {
        for (i, (words, pixels)) in row.iter().enumerate() {
            let (x, y) = (i * (wide + GAP), j * (high + LINE + GAP));
            // Strings take text without fail.
            let _ = write!(
                svg,
                "<text class=\"l\" x=\"{x}\" y=\"{}\">{}</text>\n<image x=\"{x}\" y=\"{}\" width=\"{wide}\" \
                 height=\"{high}\" href=\"data:image/png;base64,{}\"/>\n",
                y + LINE - 6,
                escape(words),
                y + LINE,
                base64(&encode(size, pixels)?)
            );
        }
    }
    svg += "</svg>\n";
    Ok(svg)
}

fn encode([width, height]: [usize; 2], pixels: &[Srgb8]) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header()?;
    let channels: Vec<u8> = pixels.iter().flat_map(|p| p.0).collect();
    writer.write_image_data(&channels)?;
    writer.finish()?;
    Ok(bytes)
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let at = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let all = at(0) << 16 | at(1) << 8 | at(2);
        for i in 0..4 {
            let letter = char::from(LETTERS[(all >> (18 - 6 * i) & 63) as usize]);
            text.push(if i <= chunk.len() { letter } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The test vectors of RFC 4648, section 10.
    #[test]
    fn base64_is_the_standards() {
        for (plain, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(plain.as_bytes()), text);
        }
    }

    #[test]
    fn pictures_stand_side_by_side_and_a_wrong_size_is_told() {
        let picture = |n: usize| ("a < b".to_owned(), vec![Srgb8([1, 2, 3]); n]);
        let svg = rows([2, 3], 100, &[vec![picture(6), picture(6)], vec![picture(6)]]).expect("of that size");
        assert_eq!((svg.matches("<image").count(), svg.matches("a &lt; b").count()), (3, 3));
        assert!(svg.contains("viewBox=\"0 0 216 356\""), "{svg}");
        assert!(rows([2, 3], 100, &[vec![picture(5)]]).is_err());
    }
}
