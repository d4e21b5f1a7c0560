//! Changes of single values of a description, as users type them.

use serde_json::Value;

use super::SceneDescription;
use crate::error::{Error, Result, suggestion};
use crate::shading::Material;

const VALUES: &str =
    "VALUE must be a finite number, a colour such as (1, 0.5, 0), a name in quotes, true or false";

impl SceneDescription {
    /// Sets a field of a material by `edit`, `MATERIAL.FIELD=VALUE`. The value is as in scene files: a number, a colour
    /// such as `(1, 0.5, 0)`, the name of a texture in quotes, or `true`. The name of the material must have no `=`.
    ///
    /// # Errors
    /// [`Error::Usage`] if the material or the field is unknown, or the value does not suit the field.
    pub fn set(&mut self, edit: &str) -> Result<()> {
        let bad = |message: String| Error::Usage(format!("--set {edit}: {message}"));
        let parts = edit.split_once('=').and_then(|(left, value)| {
            // Names of materials may contain dots, fields do not.
            left.rsplit_once('.').map(|(name, field)| (name, field, value))
        });
        let (name, field, value) =
            parts.ok_or_else(|| bad("must be MATERIAL.FIELD=VALUE".to_owned()))?;
        let materials = &mut self.file.materials.0;
        let Some(at) = materials.iter().position(|(known, _)| known == name) else {
            let near = suggestion(name, materials.iter().map(|(known, _)| known.as_str()));
            return Err(bad(format!("unknown material `{name}`{near}")));
        };
        let value: ron::Value = ron::from_str(value).map_err(|_| bad(VALUES.to_owned()))?;
        let is_texture = |value: &Value| value.get("texture").is_some();
        let value = serde_json::to_value(&value).map_err(|error| bad(error.to_string()))?;
        // Names of kinds and infinite numbers have no form here.
        if value.is_null() || value.is_object() && !is_texture(&value) {
            return Err(bad(VALUES.to_owned()));
        }
        let material = &mut materials[at].1;
        let mut fields =
            serde_json::to_value(&*material).map_err(|error| bad(error.to_string()))?;
        if let Some(fields) = fields.as_object_mut().and_then(|kinds| kinds.values_mut().next())
            && let Value::Object(fields) = fields
        {
            fields.insert(field.to_owned(), value);
        }
        *material =
            serde_json::from_value::<Material>(fields).map_err(|error| bad(error.to_string()))?;
        // The text no longer says where values are.
        self.text = None;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::formats::Source;
    use crate::limits::Limits;

    #[test]
    fn fields_of_materials_are_set() {
        let text = r#"(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40),
                       textures: {"wood": uv_checker(odd: (1, 1, 1), even: (0, 0, 0), scale: (1, 1))},
                       materials: {"top.001": principled(), "base": lambertian(albedo: (0.5, 0.5, 0.5))})"#;
        let mut description = Source::from_reader(text.as_bytes(), &Limits::default())
            .unwrap()
            .read(&Limits::default())
            .unwrap();
        for edit in [
            "top.001.roughness=0.25",
            "top.001.base_color=(1, 0.5, 0)",
            "top.001.thin=true",
            "base.albedo=\"wood\"",
        ] {
            description.set(edit).unwrap();
        }
        let shown = description.to_ron();
        for want in
            ["roughness: 0.25", "base_color: (1.0, 0.5, 0.0)", "thin: true", "albedo: \"wood\""]
        {
            assert!(shown.contains(want), "{shown}");
        }
        description.resolve().unwrap();
        for (edit, want) in [
            ("roughness=1", "must be MATERIAL.FIELD=VALUE"),
            ("bases.albedo=1", "unknown material `bases`, did you mean `base`?"),
            ("base.rough=1", "unknown field `rough`"),
            ("base.albedo=", "VALUE must be"),
            ("top.001.opacity=blend(alpha: 0.5)", "VALUE must be"),
            ("top.001.emission_sides=front", "VALUE must be"),
            ("top.001.attenuation_distance=inf", "VALUE must be"),
            ("top.001.thin=0.5", "invalid type"),
        ] {
            let error = description.set(edit).unwrap_err().to_string();
            assert!(error.contains(want) && error.contains(edit), "{error}");
        }
    }
}
