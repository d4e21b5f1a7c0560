//! Decodes the rows of a PLY file.

use glam::{Vec2, Vec3};
use ply_rs_bw::ply::{BeginList, Header, Property, PropertyAccess, PropertyAccessResult};

/// Whether the header of an element has all of these properties.
pub(super) fn has(header: &Header, element: &str, names: &[&str]) -> bool {
    let element = header.elements.get(element);
    element.is_some_and(|element| names.iter().all(|name| element.properties.contains_key(*name)))
}

/// A row of any element, with the data of a vertex and the corners of a face. Properties that the
/// element does not have keep their initial values.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) position: Vec3,
    pub(super) normal: Vec3,
    /// The texture coordinates by each of [`UVS`].
    pub(super) uvs: [Vec2; UVS.len()],
    pub(super) color: Vec3,
    /// The data of the corners of a face. Few files have any, and all rows are moved.
    pub(super) data: Option<Box<CornerData>>,
    /// Indices of vertices. Those that no `i32` can hold are -1.
    pub(super) corners: Vec<i32>,
}

/// What the corners of a face have besides their vertices.
#[derive(Debug, Default)]
pub(super) struct CornerData {
    /// Texture coordinates, two numbers each.
    pub(super) uvs: Vec<f32>,
    /// Colours, three numbers each.
    pub(super) colors: Vec<f32>,
}

/// The names of the components of normals.
pub(super) const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
/// The names of the components of colours.
pub(super) const COLOR: [&str; 3] = ["red", "green", "blue"];
/// The list of texture coordinates of a face's corners, by MeshLab.
pub(super) const CORNER_UVS: &str = "texcoord";
/// The list of colours of a face's corners, by MeshLab.
pub(super) const CORNER_COLORS: &str = "color";
/// The names that programs use for texture coordinates.
pub(super) const UVS: [[&str; 2]; 3] = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"]];

impl PropertyAccess for Row {
    fn new() -> Self {
        Self {
            position: Vec3::NAN,
            normal: Vec3::ZERO,
            uvs: [Vec2::ZERO; UVS.len()],
            color: Vec3::NAN,
            data: None,
            corners: Vec::new(),
        }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let color = COLOR.iter().position(|channel| *channel == name);
        if let (Some(place), Some(number)) = (self.number(name), value.to_f32_lossy()) {
            *place = number;
        } else if let (Some(i), Some(channel)) = (color, channel(&value)) {
            self.color[i] = channel;
        } else {
            match name {
                "vertex_indices" | "vertex_index" => match integers(value) {
                    Some(corners) => self.corners = corners,
                    None => return PropertyAccessResult::Ignored,
                },
                CORNER_UVS => self.data.get_or_insert_default().uvs = floats(&value),
                CORNER_COLORS => self.data.get_or_insert_default().colors = floats(&value),
                _ => return PropertyAccessResult::Ignored,
            }
        }
        PropertyAccessResult::Set
    }

    fn set_float(&mut self, name: &str, value: f32) -> PropertyAccessResult {
        match self.number(name) {
            Some(place) => *place = value,
            None => return self.set_property(name, Property::Float(value)),
        }
        PropertyAccessResult::Set
    }

    fn begin_list_int(&mut self, name: &str, _length: usize) -> BeginList<'_, i32> {
        match name {
            "vertex_indices" | "vertex_index" => BeginList::Fill(&mut self.corners),
            _ => BeginList::UseSetter,
        }
    }
}

impl Row {
    /// The number that a property of this name sets.
    fn number(&mut self, name: &str) -> Option<&mut f32> {
        Some(match name {
            "x" => &mut self.position.x,
            "y" => &mut self.position.y,
            "z" => &mut self.position.z,
            "nx" => &mut self.normal.x,
            "ny" => &mut self.normal.y,
            "nz" => &mut self.normal.z,
            _ => {
                let names = UVS.iter().position(|names| names.contains(&name))?;
                &mut self.uvs[names][usize::from(UVS[names][1] == name)]
            }
        })
    }
}

/// The channel of a colour. Integers are fractions of their largest value.
fn channel(value: &Property) -> Option<f32> {
    match value {
        Property::UChar(code) => Some(f32::from(*code) / 255.0),
        Property::UShort(code) => Some(f32::from(*code) / 65535.0),
        other => other.to_f32_lossy(),
    }
}

/// The numbers of a list, or none if it is no list of fractions.
fn floats(list: &Property) -> Vec<f32> {
    match list {
        Property::ListFloat(list) => list.clone(),
        Property::ListDouble(list) => list.iter().map(|number| *number as f32).collect(),
        Property::ListUChar(list) => list.iter().map(|code| f32::from(*code) / 255.0).collect(),
        _ => Vec::new(),
    }
}

fn integers(list: Property) -> Option<Vec<i32>> {
    Some(match list {
        Property::ListChar(list) => list.into_iter().map(i32::from).collect(),
        Property::ListUChar(list) => list.into_iter().map(i32::from).collect(),
        Property::ListShort(list) => list.into_iter().map(i32::from).collect(),
        Property::ListUShort(list) => list.into_iter().map(i32::from).collect(),
        Property::ListInt(list) => list,
        Property::ListUInt(list) => {
            list.into_iter().map(|index| i32::try_from(index).unwrap_or(-1)).collect()
        }
        _ => return None,
    })
}
