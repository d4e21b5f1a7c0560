//! The directives of pbrt files.

use std::rc::Rc;

use glam::{DAffine3, DMat3, DVec3};

use super::tokens::{Token, Tokens};
use super::{Params, Reader, transform};
use crate::error::suggestion;
use crate::math::affine::rows;
use crate::scene::InstanceFile;

/// Largest number of attributes, transforms and objects that may be open.
const MAX_NESTING: usize = 1000;

/// The directives with a class or name and parameters.
const WITH_CLASS: [&str; 13] = [
    "Shape",
    "Material",
    "MakeNamedMaterial",
    "LightSource",
    "AreaLightSource",
    "MakeNamedMedium",
    "Camera",
    "Film",
    "PixelFilter",
    "Sampler",
    "Integrator",
    "Accelerator",
    "Attribute",
];
/// All other directives.
const WITHOUT_CLASS: [&str; 27] = [
    "ActiveTransform",
    "AttributeBegin",
    "AttributeEnd",
    "ColorSpace",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Identity",
    "Import",
    "Include",
    "LookAt",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "ReverseOrientation",
    "Rotate",
    "Scale",
    "Texture",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "TransformTimes",
    "Translate",
    "WorldBegin",
];

impl Reader<'_, '_> {
    /// Follows one directive.
    pub(crate) fn follow(
        &mut self,
        directive: &str,
        line: usize,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), String> {
        match directive {
            "Identity" => self.set_transform(DAffine3::IDENTITY),
            "Translate" => self.apply(DAffine3::from_translation(DVec3::from(numbers(tokens)?))),
            "Scale" => {
                let scale = DVec3::from(numbers::<3>(tokens)?);
                self.apply(DAffine3::from_mat3(DMat3::from_diagonal(scale)))
            }
            "Rotate" => {
                let [angle, x, y, z] = numbers(tokens)?;
                self.apply(transform::rotation(angle, DVec3::new(x, y, z)))
            }
            "LookAt" => {
                let n: [f64; 9] = numbers(tokens)?;
                let point = |i: usize| DVec3::new(n[i], n[i + 1], n[i + 2]);
                self.apply(transform::look_at(point(0), point(3), point(6)))
            }
            "Transform" => {
                let map = transform::of_numbers(&numbers(tokens)?)?;
                self.set_transform(map)
            }
            "ConcatTransform" => self.apply(transform::of_numbers(&numbers(tokens)?)?),
            "CoordinateSystem" => {
                self.systems.insert(quoted(tokens)?, self.state.transform);
                Ok(())
            }
            "CoordSysTransform" => {
                let name = quoted(tokens)?;
                let map = self.systems.get(&name).copied();
                self.set_transform(
                    map.ok_or_else(|| format!("unknown coordinate system \"{name}\""))?,
                )
            }
            "ActiveTransform" => {
                let Some(Token::Word(which)) = tokens.next()? else {
                    return Err("expected `StartTime`, `EndTime` or `All`".to_owned());
                };
                self.state.active = which != "EndTime";
                self.import.warn("moving transforms are not supported, so everything stands still");
                Ok(())
            }
            "TransformTimes" => numbers::<2>(tokens).map(|_| ()),
            "ReverseOrientation" => {
                self.state.reversed = !self.state.reversed;
                Ok(())
            }
            "AttributeBegin" => self.save("AttributeEnd"),
            "TransformBegin" => self.save("TransformEnd"),
            "AttributeEnd" => self.restore("AttributeEnd"),
            "TransformEnd" => self.restore("TransformEnd"),
            "ObjectBegin" => {
                if self.object.is_some() {
                    return Err("objects cannot be defined within objects".to_owned());
                }
                let name = quoted(tokens)?;
                self.save("ObjectEnd")?;
                self.object = Some((name, Vec::new()));
                Ok(())
            }
            "ObjectEnd" => {
                self.restore("ObjectEnd")?;
                let (name, parts) = self.object.take().ok_or("there is no `ObjectBegin`")?;
                let fresh = self.objects.insert(name.clone(), !parts.is_empty()).is_none();
                if !fresh {
                    return Err(format!("the object \"{name}\" is defined twice"));
                }
                self.scene.add_named_mesh(name, parts);
                Ok(())
            }
            "ObjectInstance" => {
                let name = quoted(tokens)?;
                match self.objects.get(&name) {
                    None => return Err(format!("unknown object \"{name}\"")),
                    Some(false) => {}
                    Some(true) => {
                        let matrix = rows(&self.to_scene());
                        self.scene.add(InstanceFile::new(name, matrix));
                    }
                }
                Ok(())
            }
            "WorldBegin" => {
                (self.state.transform, self.state.active) = (DAffine3::IDENTITY, true);
                self.systems.insert("world".to_owned(), DAffine3::IDENTITY);
                Ok(())
            }
            "MediumInterface" => {
                let inside = quoted(tokens)?;
                let outside = match tokens.peek()? {
                    Some(Token::Text(_)) => quoted(tokens)?,
                    _ => inside.clone(),
                };
                let named = |name: String| (!name.is_empty()).then_some(name);
                (self.state.inside, self.state.outside) = (named(inside), named(outside));
                Ok(())
            }
            "NamedMaterial" => {
                let name = quoted(tokens)?;
                let definition = self.materials.named.get(&name);
                let unknown = || format!("unknown material \"{name}\"");
                self.state.material = Rc::clone(definition.ok_or_else(unknown)?);
                Ok(())
            }
            "ColorSpace" => {
                let name = quoted(tokens)?;
                if name != "srgb" {
                    self.import.warn(format!(
                        "the colour space {name} is not supported, so colours are sRGB"
                    ));
                }
                Ok(())
            }
            "Texture" => {
                let (name, kind, class) = (quoted(tokens)?, quoted(tokens)?, quoted(tokens)?);
                let params = Params::read(tokens)?;
                self.texture(&name, &kind, &class, &params)
            }
            "Option" => Params::read(tokens).map(|_| ()),
            _ => self.follow_with_class(directive, line, tokens),
        }
    }

    /// Follows a directive with a class or name and parameters.
    fn follow_with_class(
        &mut self,
        directive: &str,
        line: usize,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), String> {
        if !WITH_CLASS.contains(&directive) {
            let near = suggestion(directive, WITH_CLASS.into_iter().chain(WITHOUT_CLASS));
            return Err(format!("unknown directive `{directive}`{near}"));
        }
        let class = quoted(tokens)?;
        let params = Params::read(tokens)?;
        match directive {
            "Shape" => self.shape(&class, &params),
            "Material" => {
                self.state.material = self.materials.define(None, class, params, line);
                Ok(())
            }
            "MakeNamedMaterial" => {
                let kind = params.text("type")?.unwrap_or("diffuse").to_owned();
                let definition = self.materials.define(Some(class.clone()), kind, params, line);
                match self.materials.named.insert(class.clone(), definition) {
                    None => Ok(()),
                    Some(_) => Err(format!("the material \"{class}\" is defined twice")),
                }
            }
            "LightSource" => self.light_source(&class, &params),
            "AreaLightSource" => self.area_light_source(&class, &params),
            "MakeNamedMedium" => self.make_medium(&class, &params),
            "Camera" => self.camera(&class, &params),
            "Film" => self.film(&params),
            "PixelFilter" => self.pixel_filter(&class, &params),
            "Integrator" => self.integrator(&class, &params),
            "Sampler" => self.sampling(&params),
            "Attribute" => {
                self.import.warn("the directive Attribute is not supported, so it has no effect");
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn set_transform(&mut self, map: DAffine3) -> Result<(), String> {
        if self.state.active {
            self.state.transform = transform::checked(map)?;
        }
        Ok(())
    }

    fn apply(&mut self, map: DAffine3) -> Result<(), String> {
        self.set_transform(self.state.transform * map)
    }

    fn save(&mut self, end: &'static str) -> Result<(), String> {
        if self.saved.len() == MAX_NESTING {
            return Err(format!("attributes may be nested at most {MAX_NESTING} times"));
        }
        self.saved.push((end, self.state.clone()));
        Ok(())
    }

    fn restore(&mut self, end: &str) -> Result<(), String> {
        match self.saved.pop() {
            Some((expected, state)) if expected == end => {
                if end == "TransformEnd" {
                    self.state.transform = state.transform;
                } else {
                    self.state = state;
                }
                Ok(())
            }
            Some((expected, _)) => Err(format!("`{end}` where `{expected}` is expected")),
            None => Err(format!("`{end}` without its beginning")),
        }
    }
}

/// The text in quotes that follows.
pub(crate) fn quoted(tokens: &mut Tokens<'_>) -> Result<String, String> {
    match tokens.next()? {
        Some(Token::Text(text)) => Ok(text.into_owned()),
        _ => Err("expected a text in quotes".to_owned()),
    }
}

/// N numbers, with or without brackets.
fn numbers<const N: usize>(tokens: &mut Tokens<'_>) -> Result<[f64; N], String> {
    let brackets = tokens.peek()? == Some(&Token::Open);
    if brackets {
        tokens.next()?;
    }
    let mut all = [0.0; N];
    for number in &mut all {
        match tokens.next()? {
            Some(Token::Number(value)) => *number = value,
            _ => return Err(format!("expected {N} numbers")),
        }
    }
    match brackets.then(|| tokens.next()).transpose()? {
        None | Some(Some(Token::Close)) => Ok(all),
        Some(_) => Err(format!("expected a bracket after {N} numbers")),
    }
}
