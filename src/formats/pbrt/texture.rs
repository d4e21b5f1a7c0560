//! Textures of pbrt files, and parameters that may be textures.

use std::collections::{HashMap, HashSet};

use super::{Param, Params, Reader, Values, spectrum};
use crate::image::Encoding;
use crate::shading::texture::{Channel, Filter, Image, UvChecker, Wrap};
use crate::shading::{Color, Number, Texture, TextureRef};

/// A colour or a number: a constant, or a texture of the scene times a constant.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Constant([f64; 3]),
    Texture { name: String, factor: [f64; 3] },
}

/// A [`Value`] as a key. Its numbers are compared by their bits.
#[derive(PartialEq, Eq, Hash)]
pub(crate) struct ValueKey {
    texture: Option<String>,
    numbers: [u64; 3],
}

impl Value {
    pub(crate) fn key(&self) -> ValueKey {
        let (texture, numbers) = match self {
            Self::Constant(value) => (None, value),
            Self::Texture { name, factor } => (Some(name.clone()), factor),
        };
        ValueKey { texture, numbers: numbers.map(f64::to_bits) }
    }

    pub(crate) fn number(value: f64) -> Self {
        Self::Constant([value; 3])
    }

    fn times(&self, by: [f64; 3]) -> Self {
        let product = |a: [f64; 3]| [a[0] * by[0], a[1] * by[1], a[2] * by[2]];
        match self {
            Self::Constant(value) => Self::Constant(product(*value)),
            Self::Texture { name, factor } => {
                Self::Texture { name: name.clone(), factor: product(*factor) }
            }
        }
    }

    /// As a reflectance, limited to [0, 1].
    pub(crate) fn color(&self) -> Color {
        let limited = |color: [f64; 3]| color.map(|c| c.clamp(0.0, 1.0) as f32);
        match self {
            Self::Constant(color) => Color::Rgb(limited(*color)),
            Self::Texture { name, factor } => Color::Texture {
                texture: TextureRef::Named(name.clone()),
                factor: limited(*factor),
            },
        }
    }

    /// As a number in [0, 1], with constants changed by `map`.
    pub(crate) fn mapped(&self, map: impl Fn(f64) -> f64) -> Number {
        match self {
            Self::Constant([value, ..]) => Number::Value(map(*value).clamp(0.0, 1.0) as f32),
            Self::Texture { name, factor } => Number::Texture {
                texture: TextureRef::Named(name.clone()),
                channel: Channel::R,
                factor: factor[0].clamp(0.0, 1.0) as f32,
            },
        }
    }
}

/// The textures defined so far, by name.
#[derive(Default)]
pub(crate) struct Textures {
    pub(crate) colors: HashMap<String, Value>,
    pub(crate) numbers: HashMap<String, Value>,
    /// The names in the scene.
    names: HashSet<String>,
}

impl Reader<'_, '_> {
    /// The directive `Texture`.
    pub(crate) fn texture(
        &mut self,
        name: &str,
        kind: &str,
        class: &str,
        params: &Params,
    ) -> Result<(), String> {
        let value = match class {
            "constant" => self.value(params, "value", kind)?.unwrap_or(Value::number(1.0)),
            "imagemap" => self.image_map(name, kind, params)?,
            "scale" => {
                let texture = self.value(params, "tex", kind)?.unwrap_or(Value::number(1.0));
                let scale = self.value(params, "scale", "float")?.unwrap_or(Value::number(1.0));
                match (texture, scale) {
                    (texture, Value::Constant(scale)) => texture.times(scale),
                    (Value::Constant(color), texture) => texture.times(color),
                    (texture, _) => {
                        self.import.warn(
                            "products of two textures are not supported, so the first is used",
                        );
                        texture
                    }
                }
            }
            "mix" => self.mix(params, kind)?,
            "checkerboard" => self.checkerboard(name, kind, params)?,
            _ => {
                self.import.warn(format!(
                    "textures of the class {class} are not supported, so they are grey"
                ));
                return self.define(name, kind, Value::number(0.5));
            }
        };
        self.warn_unused(params, &format!("{class} textures"));
        self.define(name, kind, value)
    }

    fn define(&mut self, name: &str, kind: &str, value: Value) -> Result<(), String> {
        let textures = match kind {
            "float" => &mut self.textures.numbers,
            "spectrum" | "color" => &mut self.textures.colors,
            _ => {
                return Err(format!(
                    "a texture must be of the type float or spectrum, is `{kind}`"
                ));
            }
        };
        textures.insert(name.to_owned(), value);
        Ok(())
    }

    fn image_map(&mut self, name: &str, kind: &str, params: &Params) -> Result<Value, String> {
        let file = params.text("filename")?.ok_or("an image map needs a `filename`")?.to_owned();
        let mut image = Image::from_file(&*file);
        match params.text("encoding")? {
            None | Some("sRGB") => {}
            Some("linear") => image.encoding = Encoding::Linear,
            Some(other) => {
                self.import.warn(format!("the encoding {other} is not supported, so it is sRGB"));
            }
        }
        if params.text("filter")? == Some("point") {
            image.filter = Filter::Nearest;
        }
        let wrap = match params.text("wrap")? {
            None | Some("repeat") => Wrap::Repeat,
            Some("clamp") => Wrap::Clamp,
            Some(other) => {
                self.import
                    .warn(format!("the wrap mode {other} is not supported, so edges continue"));
                Wrap::Clamp
            }
        };
        (image.wrap_u, image.wrap_v) = (wrap, wrap);
        let [scale, offset] = self.mapping(params)?;
        (image.scale, image.offset) = (scale, offset);
        params.ignore(&["maxanisotropy"]);
        if params.flag("invert")? == Some(true) {
            self.import.warn("inverted textures are not supported, so they are not inverted");
        }
        let scale = params.number("scale")?.unwrap_or(1.0);
        if !(0.0..=1.0).contains(&scale) {
            self.import
                .warn("scales of textures outside [0, 1] are not supported, so they are limited");
        }
        let factor = [scale; 3];
        if !self.import.is_usable(&file, "so it is grey") {
            return Ok(Value::number(0.5));
        }
        Ok(Value::Texture { name: self.add_texture(name, kind, image), factor })
    }

    /// The factors and offsets of texture coordinates.
    fn mapping(&mut self, params: &Params) -> Result<[(f32, f32); 2], String> {
        if let Some(other) = params.text("mapping")?.filter(|mapping| *mapping != "uv") {
            self.import
                .warn(format!("the mapping {other} is not supported, so textures use u and v"));
        }
        let pair = |u: &str, v: &str, usual: f64| -> Result<(f32, f32), String> {
            let number = |name| params.number(name).map(|n| n.unwrap_or(usual) as f32);
            Ok((number(u)?, number(v)?))
        };
        Ok([pair("uscale", "vscale", 1.0)?, pair("udelta", "vdelta", 0.0)?])
    }

    fn mix(&mut self, params: &Params, kind: &str) -> Result<Value, String> {
        let first = self.value(params, "tex1", kind)?.unwrap_or(Value::number(0.0));
        let second = self.value(params, "tex2", kind)?.unwrap_or(Value::number(1.0));
        let amount = self.value(params, "amount", "float")?.unwrap_or(Value::number(0.5));
        Ok(match (first, second, amount) {
            (Value::Constant(a), Value::Constant(b), Value::Constant([t, ..])) => {
                Value::Constant([0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * t))
            }
            (first, second, amount) => {
                self.import
                    .warn("mixtures of textures are not supported, so the larger part is used");
                let more = matches!(amount, Value::Constant([t, ..]) if t > 0.5);
                if more { second } else { first }
            }
        })
    }

    fn checkerboard(&mut self, name: &str, kind: &str, params: &Params) -> Result<Value, String> {
        let mut constant = |key: &str, usual| -> Result<[f32; 3], String> {
            match self.value(params, key, kind)? {
                None => Ok([usual; 3]),
                Some(Value::Constant(color)) => Ok(color.map(|c| c.clamp(0.0, 1.0) as f32)),
                Some(Value::Texture { .. }) => {
                    self.import
                        .warn("textures in checkerboards are not supported, so they are grey");
                    Ok([0.5; 3])
                }
            }
        };
        let (even, odd) = (constant("tex1", 1.0)?, constant("tex2", 0.0)?);
        if params.number("dimension")?.is_some_and(|dimension| dimension != 2.0) {
            self.import
                .warn("checkerboards of 3 dimensions are not supported, so they use u and v");
        }
        let [scale, offset] = self.mapping(params)?;
        let checker = UvChecker { odd, even, scale, offset };
        Ok(Value::Texture { name: self.add_texture(name, kind, checker), factor: [1.0; 3] })
    }

    /// Adds a texture of a name like `name`, and returns its name.
    fn add_texture(&mut self, name: &str, kind: &str, texture: impl Into<Texture>) -> String {
        let named = self.textures.names.len();
        let own = [name.to_owned(), format!("{name} ({kind})"), format!("{name} {named}")]
            .into_iter()
            .find(|own| self.textures.names.insert(own.clone()))
            .unwrap_or_else(|| format!("texture {named}"));
        self.scene.add_texture(own.clone(), texture);
        own
    }

    /// The parameter `name`, which may be a texture of this kind.
    pub(crate) fn value(
        &mut self,
        params: &Params,
        name: &str,
        kind: &str,
    ) -> Result<Option<Value>, String> {
        let Some(param) = params.find(name) else { return Ok(None) };
        match (param.kind.as_str(), &param.values) {
            ("texture", Values::Texts(texts)) if texts.len() == 1 => {
                let textures = match kind {
                    "float" => &self.textures.numbers,
                    _ => &self.textures.colors,
                };
                let found = textures.get(&texts[0]).cloned();
                found.map(Some).ok_or_else(|| format!("`{name}`: unknown texture \"{}\"", texts[0]))
            }
            _ => self.spectrum(param).map(|color| Some(Value::Constant(color))),
        }
    }

    /// Linear RGB of a spectrum. One that ptfast does not know is grey, with a warning.
    pub(crate) fn spectrum(&mut self, param: &Param) -> Result<[f64; 3], String> {
        match (&*param.kind, spectrum::rgb(param)) {
            ("spectrum", Err(message)) => {
                self.import.warn(format!("{message}, so it is 0.5"));
                Ok([0.5; 3])
            }
            (_, rgb) => rgb,
        }
    }
}
