//! The material definitions of a file, and the materials of the scene that they have become.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::{Params, ValueKey};

/// A material as its directive describes it.
#[derive(Debug)]
pub(crate) struct Definition {
    /// Number of definitions before this one.
    pub(crate) index: usize,
    /// The name in the file; `None` for the directive `Material`.
    pub(crate) name: Option<String>,
    pub(crate) class: String,
    pub(crate) params: Params,
    /// Line of the directive.
    pub(crate) line: usize,
}

impl Definition {
    /// Whether surfaces do not change light.
    pub(crate) fn is_invisible(&self) -> bool {
        matches!(self.class.as_str(), "interface" | "" | "none")
    }

    /// Whether surfaces scatter no light, as is usual for lamps.
    pub(crate) fn is_black(&self) -> bool {
        let reflectance = self.params.numbers("reflectance").ok().flatten();
        self.is_invisible() || reflectance.is_some_and(|rgb| rgb.iter().all(|c| *c == 0.0))
    }
}

/// Everything that determines a material of the scene.
#[derive(PartialEq, Eq, Hash)]
pub(crate) struct MaterialKey {
    /// [`Definition::index`].
    pub(crate) definition: usize,
    /// The medium inside.
    pub(crate) inside: Option<String>,
    pub(crate) alpha: Option<ValueKey>,
}

/// The materials of a file.
#[derive(Default)]
pub(crate) struct Materials {
    /// Number of definitions so far.
    count: usize,
    pub(crate) named: HashMap<String, Rc<Definition>>,
    /// The names in the scene.
    pub(crate) known: HashMap<MaterialKey, String>,
    names: HashSet<String>,
    /// The names in the scene of the materials that have textures.
    pub(crate) textured: HashSet<String>,
}

impl Materials {
    /// Numbers a definition.
    pub(crate) fn define(
        &mut self,
        name: Option<String>,
        class: String,
        params: Params,
        line: usize,
    ) -> Rc<Definition> {
        let index = self.count;
        self.count += 1;
        Rc::new(Definition { index, name, class, params, line })
    }

    /// A name like `name` that no material of the scene has yet.
    pub(crate) fn unique(&mut self, name: &str) -> String {
        let number = self.names.len();
        crate::formats::import::unique(&mut self.names, name, number)
    }
}
