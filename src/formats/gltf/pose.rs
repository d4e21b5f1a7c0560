//! Where the nodes of a glTF file are: at rest, or at a time of an animation.

use std::collections::HashMap;

use glam::DAffine3;

use super::file::{Animation, Gltf, Node};
use super::placed;
use crate::error::suggestion;
use crate::formats::import::Import;
use crate::math::affine;

/// The values that an animation gives to nodes.
#[derive(Debug, Default)]
pub(crate) struct Pose {
    translations: HashMap<usize, [f64; 3]>,
    rotations: HashMap<usize, [f64; 4]>,
    scales: HashMap<usize, [f64; 3]>,
    /// Weights of morph targets.
    pub(crate) weights: HashMap<usize, Vec<f64>>,
}

impl Pose {
    /// The pose that the options choose.
    pub(crate) fn new(gltf: &Gltf<'_>, import: &mut Import<'_>) -> Result<Self, String> {
        let Some((name, animation)) = chosen(gltf, import)? else {
            if !gltf.document.animations.is_empty() {
                import.note(
                    "is shown at rest; `--animation` and `--at` choose an animation and its time",
                );
            }
            return Ok(Self::default());
        };
        let mut pose = Self::default();
        for i in 0..animation.channels.len() {
            pose.follow(gltf, animation, i, import.options.at)
                .map_err(|message| format!("the animation `{name}`: {message}"))?;
        }
        Ok(pose)
    }

    /// Sets the values of one channel at the time `at` in seconds.
    fn follow(
        &mut self,
        gltf: &Gltf<'_>,
        animation: &Animation,
        channel: usize,
        at: f64,
    ) -> Result<(), String> {
        let channel = &animation.channels[channel];
        let Some(node) = channel.target.node else { return Ok(()) };
        let sampler = animation.samplers.get(channel.sampler).ok_or("a channel has no sampler")?;
        let times = gltf.vectors::<1>(sampler.input)?;
        let times: Vec<f64> = times.into_iter().map(|[time]| f64::from(time)).collect();
        let interpolation = sampler.interpolation.as_deref().unwrap_or("LINEAR");
        let keys = Keys { times: &times, interpolation, at };
        match &*channel.target.path {
            "translation" => {
                let value = keys.value(&gltf.vectors::<3>(sampler.output)?, false)?;
                self.translations.insert(node, value);
            }
            "scale" => {
                let value = keys.value(&gltf.vectors::<3>(sampler.output)?, false)?;
                self.scales.insert(node, value);
            }
            "rotation" => {
                let value = keys.value(&gltf.vectors::<4>(sampler.output)?, true)?;
                self.rotations.insert(node, value);
            }
            "weights" => {
                let all = gltf.vectors::<1>(sampler.output)?;
                let parts = if interpolation == "CUBICSPLINE" { 3 } else { 1 };
                let count = all.len() / (parts * times.len()).max(1);
                let weight = |i: usize| {
                    let own: Vec<_> = all.iter().skip(i).step_by(count.max(1)).copied().collect();
                    keys.value(&own, false).map(|[weight]| weight)
                };
                self.weights.insert(node, (0..count).map(weight).collect::<Result<_, _>>()?);
            }
            _ => {}
        }
        Ok(())
    }

    /// From a node to its parent.
    pub(crate) fn local(&self, index: usize, node: &Node) -> DAffine3 {
        let own = (
            self.translations.get(&index).copied(),
            self.rotations.get(&index).copied(),
            self.scales.get(&index).copied(),
        );
        match (node.matrix, own) {
            (Some(columns), (None, None, None)) => affine::of_columns(&columns),
            (_, (translation, rotation, scale)) => placed(
                translation.or(node.translation),
                rotation.or(node.rotation),
                scale.or(node.scale),
            ),
        }
    }
}

/// The animation that the options choose, by name or number, and that name.
fn chosen<'a, 'g>(
    gltf: &'g Gltf<'_>,
    import: &Import<'a>,
) -> Result<Option<(&'a str, &'g Animation)>, String> {
    let animations = &gltf.document.animations;
    let Some(name) = import.options.animation.as_deref() else { return Ok(None) };
    let names = || animations.iter().filter_map(|animation| animation.name.as_deref());
    let number = name.parse().ok().and_then(|number: usize| animations.get(number));
    let found = animations.iter().find(|animation| animation.name.as_deref() == Some(name));
    let animation = found
        .or(number)
        .ok_or_else(|| format!("unknown animation `{name}`{}", suggestion(name, names())))?;
    Ok(Some((name, animation)))
}

/// Eight times from the beginning to the end of the animation that the options choose.
pub(super) fn times(gltf: &Gltf<'_>, import: &Import<'_>) -> Result<Option<[f64; 8]>, String> {
    let Some((_, animation)) = chosen(gltf, import)? else { return Ok(None) };
    let (mut begin, mut end) = (f64::INFINITY, f64::NEG_INFINITY);
    for sampler in &animation.samplers {
        for [time] in gltf.vectors::<1>(sampler.input)? {
            let time = f64::from(time);
            begin = if time < begin { time } else { begin };
            end = if time > end { time } else { end };
        }
    }
    let times = std::array::from_fn(|i| begin + (end - begin) * (i as f64 / 7.0));
    Ok((begin <= end).then_some(times))
}

/// The times of keyframes, and the time whose value is wanted.
struct Keys<'a> {
    times: &'a [f64],
    interpolation: &'a str,
    at: f64,
}

impl Keys<'_> {
    /// The interpolated value, which for a `rotation` is a quaternion.
    fn value<const N: usize>(
        &self,
        values: &[[f32; N]],
        rotation: bool,
    ) -> Result<[f64; N], String> {
        let cubic = self.interpolation == "CUBICSPLINE";
        let parts = if cubic { 3 } else { 1 };
        let Some(last) = self.times.len().checked_sub(1) else {
            return Err("a sampler has no times".to_owned());
        };
        if values.len() < parts * self.times.len() {
            return Err("a sampler has fewer values than times".to_owned());
        }
        let value = |key: usize| values[parts * key + parts / 2].map(f64::from);
        let after = self.times.partition_point(|&time| time <= self.at);
        if after == 0 || after > last {
            return Ok(value(if after == 0 { 0 } else { last }));
        }
        let (from, to) = (value(after - 1), value(after));
        let span = self.times[after] - self.times[after - 1];
        let t = if span > 0.0 { (self.at - self.times[after - 1]) / span } else { 0.0 };
        Ok(match self.interpolation {
            "STEP" => from,
            "CUBICSPLINE" => {
                // Hermite splines; the tangents are beside the values.
                let out = values[3 * (after - 1) + 2].map(f64::from);
                let into = values[3 * after].map(f64::from);
                let (t2, t3) = (t * t, t * t * t);
                std::array::from_fn(|i| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * from[i]
                        + span * (t3 - 2.0 * t2 + t) * out[i]
                        + (3.0 * t2 - 2.0 * t3) * to[i]
                        + span * (t3 - t2) * into[i]
                })
            }
            _ if rotation => slerp(from, to, t),
            _ => std::array::from_fn(|i| from[i] + (to[i] - from[i]) * t),
        })
    }
}

/// Spherical interpolation of unit vectors, by halving the arc once for each binary digit of `t`, which
/// needs no trigonometry.
fn slerp<const N: usize>(mut from: [f64; N], mut to: [f64; N], mut t: f64) -> [f64; N] {
    let product: f64 = from.iter().zip(&to).map(|(a, b)| a * b).sum();
    if product < 0.0 {
        to = to.map(|c| -c);
    }
    for _ in 0..40 {
        let sum: [f64; N] = std::array::from_fn(|i| from[i] + to[i]);
        let length = sum.iter().map(|c| c * c).sum::<f64>().sqrt();
        let middle = sum.map(|c| c / length);
        (from, to, t) = if t < 0.5 { (from, middle, 2.0 * t) } else { (middle, to, 2.0 * t - 1.0) };
    }
    from
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_follow_the_arc() {
        let third = slerp([1.0, 0.0], [0.0, 1.0], 1.0 / 3.0);
        assert!(
            (third[0] - 0.75f64.sqrt()).abs() < 1e-9 && (third[1] - 0.5).abs() < 1e-9,
            "{third:?}"
        );
        // The shorter of the two arcs.
        let half = slerp([1.0, 0.0], [-0.6, 0.8], 0.5);
        assert!((half[0] - 0.8f64.sqrt()).abs() < 1e-9 && half[1] < 0.0, "{half:?}");
    }

    #[test]
    fn values_between_keys() {
        let times = [1.0, 2.0, 4.0];
        let at = |at, interpolation, values: &[[f32; 1]]| {
            Keys { times: &times, interpolation, at }.value(values, false).unwrap()[0]
        };
        let values = [[0.0], [2.0], [6.0]];
        assert_eq!([0.0, 1.5, 3.0, 9.0].map(|t| at(t, "LINEAR", &values)), [0.0, 1.0, 4.0, 6.0]);
        assert_eq!([1.5, 3.9].map(|t| at(t, "STEP", &values)), [0.0, 2.0]);
        // A cubic with the slope 2 everywhere is a line.
        let cubic = [[2.0], [0.0], [2.0], [2.0], [2.0], [2.0], [2.0], [6.0], [2.0]];
        assert!((at(3.0, "CUBICSPLINE", &cubic) - 4.0).abs() < 1e-12);
    }
}
