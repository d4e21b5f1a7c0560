//! Layers as pictures: false colours for what is no colour.

use crate::engine::Layer;
use crate::image::{Display, Image};
use crate::math::{max, min};

/// The codes of a layer of `image`, four for each pixel. Colours are shown by `display`, numbers in false colours.
pub(super) fn paint(image: &Image, layer: Layer, display: &Display) -> Vec<u8> {
    let values = image.layer(layer.name()).map(|layer| layer.values()).unwrap_or_default();
    let plain = Display { half_layers: false, ..Display::default() };
    let finite = |x: f32| if x.is_finite() { x } else { 0.0 };
    match layer {
        Layer::Direct | Layer::Indirect | Layer::Emission | Layer::Background => {
            display.rgba(values)
        }
        Layer::Albedo => plain.rgba(values),
        Layer::Normal => mapped(&plain, values, |n| n.map(|c| 0.5 + 0.5 * c)),
        Layer::Uv => mapped(&plain, values, |uv| uv.map(|c| finite(c - c.floor()))),
        Layer::Instance | Layer::Material => {
            mapped(&plain, values, |[number, ..]| color_of(number))
        }
        Layer::Alpha => mapped(&plain, values, |[alpha, ..]| [alpha; 3]),
        _ => {
            // From the least to the largest value.
            let ends = |(least, most): (f32, f32), x: f32| (min(least, x), max(most, x));
            let channels = layer.facts().0.len();
            let all = values.iter().flat_map(|value| &value[..channels]);
            let all = all.copied().filter(|x| x.is_finite());
            let (least, most) = all.fold((f32::INFINITY, f32::NEG_INFINITY), ends);
            let scale = if most > least { 1.0 / (most - least) } else { 0.0 };
            mapped(&plain, values, |v| {
                let shown = v.map(|x| finite((x - least) * scale));
                if channels == 1 { [shown[0]; 3] } else { shown }
            })
        }
    }
}

fn mapped(display: &Display, values: &[[f32; 3]], color: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<u8> {
    let colors: Vec<[f32; 3]> = values.iter().map(|value| color(*value)).collect();
    display.rgba(&colors)
}

/// A colour that tells neighbouring numbers apart; black for 0.
fn color_of(number: f32) -> [f32; 3] {
    if number == 0.0 {
        return [0.0; 3];
    }
    // Multiples of irrational numbers spread evenly.
    [0.618_034, 0.754_878, 0.569_84].map(|step: f32| {
        let share = number * step;
        0.15 + 0.85 * (share - share.floor())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ImageLayer;

    fn painted(layer: Layer, values: Vec<[f32; 3]>) -> Vec<u8> {
        let image = Image::new(values.len() as u32, 1);
        let channels = layer.facts().0;
        let layers = vec![ImageLayer { name: layer.name(), channels, numbers: false, values }];
        paint(&image.with_layers(layers), layer, &Display::default())
    }

    #[test]
    fn numbers_have_different_colours_and_depths_fill_the_range() {
        let codes = painted(Layer::Instance, vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
        assert_eq!(codes[..4], [0, 0, 0, 255]);
        assert!(codes[4..7] != codes[8..11] && codes[4] > 0);
        let codes =
            painted(Layer::Depth, vec![[2.0, 0.0, 0.0], [6.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0]]);
        assert_eq!(codes, [0, 0, 0, 255, 255, 255, 255, 255, 0, 0, 0, 255]);
        let codes = painted(Layer::Normal, vec![[-1.0, 0.0, 1.0]]);
        assert_eq!((codes[0], codes[2]), (0, 255));
    }
}
