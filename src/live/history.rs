//! Reprojection: the colours of earlier frames, moved to where a moving camera sees the same points now.
//!
//! What it gives is for display only, since it depends on what was shown before.

use std::mem;

use glam::Vec3;
use rayon::prelude::*;

use crate::engine::{Layer, Layers};
use crate::film::Film;
use crate::image::{Image, ImageLayer};
use crate::math::{dot, length};
use crate::shading::CameraFrame;

/// Most samples that a colour is the mean of: older ones fade, since resampling blurs and light changes.
const MOST: f32 = 24.0;
/// Points this far from the tangent plane of a surface, in its distances from the camera, are on another surface.
const APART: f32 = 0.01;
/// How far the background seems to be.
const FAR: f32 = 1e6;
/// The layers of a frame.
pub(super) const LAYERS: [Layer; 5] =
    [Layer::Alpha, Layer::Albedo, Layer::Normal, Layer::Depth, Layer::Position];

/// A pixel of the last frame.
#[derive(Clone, Copy, Debug, Default)]
struct Pixel {
    color: Vec3,
    /// Of how many samples the colour is the mean.
    samples: f32,
    position: Vec3,
    /// The share of the pixel that is not background.
    covered: f32,
}

/// The last frame, as the next one uses it.
#[derive(Debug, Default)]
pub(crate) struct History {
    camera: Option<CameraFrame>,
    width: usize,
    pixels: Vec<Pixel>,
    /// The memory of the frame before.
    spare: Vec<Pixel>,
}

/// A row of a frame.
struct Row<'a> {
    pixels: &'a mut [Pixel],
    colors: &'a mut [[f32; 3]],
    albedo: &'a mut [[f32; 3]],
    normal: &'a mut [[f32; 3]],
    depth: &'a mut [[f32; 3]],
}

impl History {
    /// Whether there is no frame.
    pub(crate) fn is_empty(&self) -> bool {
        self.pixels.is_empty()
    }

    /// The distance along the direction of view at a place of the last frame, in shares of its width and height; `None`
    /// for the background.
    pub(crate) fn depth(&self, x: f32, y: f32) -> Option<f32> {
        let (camera, width) = (self.camera.as_ref()?, self.width.max(1));
        let height = self.pixels.len() / width;
        let pixel = self.row((y * height as f32) as i64)?.get((x * width as f32) as usize)?;
        (pixel.covered > 0.0).then(|| camera.depth::<f32>(pixel.position))
    }

    /// Adds a frame with one sample per pixel, which `camera` sees, and returns the mean colours, with the layers that
    /// denoising uses. The film has the layers `stored`, among them [`LAYERS`]. Threads of the current pool share the
    /// work.
    pub(crate) fn blend(&mut self, film: &Film, stored: &Layers, camera: CameraFrame) -> Image {
        let area = film.area();
        let (width, count) = (area.width as usize, area.pixels() as usize);
        let mut pixels = mem::take(&mut self.spare);
        pixels.resize(count, Pixel::default());
        let [mut colors, mut albedo, mut normal, mut depth] =
            [(); 4].map(|()| vec![[0.0; 3]; count]);
        let places = LAYERS.map(|wanted| {
            let mut places = stored.places();
            places
                .find(|(layer, _)| *layer == wanted)
                .expect("the film has the layers of a frame")
                .1
        });
        let rows = pixels.par_chunks_mut(width).zip(colors.par_chunks_mut(width));
        let rows = rows.zip(albedo.par_chunks_mut(width)).zip(normal.par_chunks_mut(width));
        let rows = rows.zip(depth.par_chunks_mut(width)).enumerate();
        rows.for_each(|(y, ((((pixels, colors), albedo), normal), depth))| {
            let row = Row { pixels, colors, albedo, normal, depth };
            self.blend_row(film, y as u32, places, &camera, row);
        });
        self.spare = mem::replace(&mut self.pixels, pixels);
        (self.camera, self.width) = (Some(camera), width);
        let layer = |name, channels, values| ImageLayer { name, channels, numbers: false, values };
        Image::from_pixels(area.width, area.height, colors).with_layers(vec![
            layer("albedo", &["R", "G", "B"], albedo),
            layer("normal", &["X", "Y", "Z"], normal),
            layer("depth", &["Z"], depth),
        ])
    }

    fn blend_row(
        &self,
        film: &Film,
        y: u32,
        [alpha, albedo, normal, depth, position]: [usize; 5],
        camera: &CameraFrame,
        row: Row<'_>,
    ) {
        let (eye, mut x) = (camera.eye(), 0);
        film.totals(y, |sums, _| {
            let three = |place: usize| [sums[place], sums[place + 1], sums[place + 2]];
            let covered = sums[alpha];
            let position = match covered > 0.0 {
                true => Vec3::from(three(position)),
                false => eye + camera.toward(x as f32 + 0.5, y as f32 + 0.5) * FAR,
            };
            let here = Pixel { color: three(0).into(), samples: 1.0, position, covered };
            let here = self.followed(here, three(normal).into(), length(position - eye));
            row.pixels[x] = here;
            row.colors[x] = here.color.to_array();
            row.albedo[x] = three(albedo);
            row.normal[x] = three(normal);
            row.depth[x] = [sums[depth], 0.0, 0.0];
            x += 1;
        });
    }

    /// `here`, at this distance from the camera, with the colours that it had before.
    fn followed(&self, here: Pixel, normal: Vec3, distance: f32) -> Pixel {
        let camera = self.camera.as_ref();
        let Some((x, y)) = camera.and_then(|camera| camera.project(here.position)) else {
            return here;
        };
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (across, down) = (x - 0.5 - left, y - 0.5 - top);
        let most = APART * distance;
        let (mut color, mut samples, mut weights) = (Vec3::ZERO, 0.0, 0.0);
        for (row, weight) in [(0, 1.0 - down), (1, down)] {
            let Some(row) = self.row((top as i64).saturating_add(row)) else { continue };
            for (column, along) in [(0, 1.0 - across), (1, across)] {
                let column = usize::try_from((left as i64).saturating_add(column));
                let Some(there) = column.ok().and_then(|column| row.get(column)) else { continue };
                let apart = dot(there.position - here.position, normal).abs();
                let same = (there.covered > 0.0) == (here.covered > 0.0) && apart <= most;
                // Without a branch, since neither is rare at edges.
                let weight = if same { weight * along } else { 0.0 };
                color += there.color * weight;
                samples += there.samples * weight;
                weights += weight;
            }
        }
        if weights < 0.05 {
            return here;
        }
        let color = color / weights;
        let samples = (samples / weights).clamp(0.0, MOST - 1.0) + 1.0;
        Pixel { color: color + (here.color - color) / samples, samples, ..here }
    }

    /// A row of the last frame.
    fn row(&self, y: i64) -> Option<&[Pixel]> {
        let begin = usize::try_from(y).ok()?.checked_mul(self.width)?;
        self.pixels.get(begin..begin.checked_add(self.width)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Tile, Unit, UnitSums};
    use crate::shading::{Camera, CameraFile};

    const SIDE: u32 = 8;

    fn frame(x: f32) -> CameraFrame {
        let file = CameraFile::new([x, 0.0, 4.0], [x, 0.0, 0.0], 90.0);
        Camera::try_from(&file).unwrap().frame(SIDE, SIDE)
    }

    /// Adds a frame with a wall of one colour at z = 0, whose normals are not always right.
    fn add(history: &mut History, camera: &CameraFrame, color: f32, normal: [f32; 3]) -> Image {
        let stored = Layers::new(LAYERS).stored();
        let area = Tile { x: 0, y: 0, width: SIDE, height: SIDE };
        let mut film = Film::new(area, 0..1, stored.channels()).unwrap();
        let mut sums = Vec::new();
        for pixel in 0..SIDE * SIDE {
            let (x, y) = area.pixel(pixel);
            let toward = camera.toward(x as f32 + 0.5, y as f32 + 0.5);
            let point = camera.eye() + toward * (-4.0 / toward.z);
            sums.extend([color; 3]);
            for (layer, _) in stored.places() {
                match layer {
                    Layer::Normal => sums.extend(normal),
                    Layer::Position => sums.extend(point.to_array()),
                    other => sums.extend(vec![1.0; other.facts().0.len()]),
                }
            }
        }
        film.add(&UnitSums { unit: Unit { tile: area, first: 0, end: 1 }, sums }).unwrap();
        history.blend(&film, &stored, camera.clone())
    }

    const FRONT: [f32; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn a_camera_at_rest_takes_means() {
        let (mut history, camera) = (History::default(), frame(0.0));
        for (color, mean) in [(1.0, 1.0), (0.0, 0.5), (0.0, 1.0 / 3.0)] {
            let image = add(&mut history, &camera, color, FRONT);
            let differ = image.pixels().iter().flatten().any(|c| (c - mean).abs() > 1e-5);
            assert!(!differ, "{:?}", image.pixels());
            assert_eq!(image.layer("normal").unwrap().values()[9], FRONT);
        }
        assert!(history.pixels.iter().all(|pixel| (pixel.samples - 3.0).abs() < 1e-5));
        assert!((history.depth(0.5, 0.5).unwrap() - 4.0).abs() < 1e-5);
    }

    /// The view is 8 high and wide at the wall: a pixel is one unit.
    #[test]
    fn colours_follow_the_wall_and_what_was_not_seen_is_new() {
        let mut history = History::default();
        add(&mut history, &frame(0.0), 1.0, FRONT);
        let image = add(&mut history, &frame(2.0), 0.0, FRONT);
        for (i, mean) in image.pixels().iter().enumerate() {
            let seen = i % 8 < 6;
            assert!((mean[0] - if seen { 0.5 } else { 0.0 }).abs() < 1e-4, "{i}: {mean:?}");
        }
        // Nearer by far more than a surface could be.
        let camera = frame(2.0);
        let mut other = History::default();
        add(&mut other, &camera, 1.0, FRONT);
        other.pixels.iter_mut().for_each(|pixel| pixel.position.z += 1.0);
        assert!(add(&mut other, &camera, 0.0, FRONT).pixels().iter().all(|mean| *mean == [0.0; 3]));
    }
}
