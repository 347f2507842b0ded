//! Finds the file that defines what a path names, through imports and re-exports.

use std::path::Path;

use super::source::{Import, Mention, MentionKind, Source};

/// Imports that lead on to imports end somewhere; a circle of re-exports does not compile.
const MAX_IMPORTS: usize = 32;

#[derive(Clone, Copy)]
enum Target {
    Module(usize),
    /// Something that this module defines.
    Item(usize),
}

/// Follows names through the modules of a crate.
pub(crate) struct Resolver<'a> {
    pub(crate) source: &'a Source,
}

impl<'a> Resolver<'a> {
    /// The file that defines what is mentioned; none if that is a module as such, a local name or another
    /// crate's.
    pub(crate) fn definition(&self, mention: &Mention) -> Option<&'a Path> {
        if let (MentionKind::Macro, [name]) = (mention.kind, mention.path.as_slice())
            && let Some(file) = self.source.macros.get(name)
        {
            return Some(file);
        }
        match (self.resolve(mention.module, &mention.path, MAX_IMPORTS)?, mention.kind) {
            (Target::Item(module), _) | (Target::Module(module), MentionKind::Inside) => {
                Some(&self.source.modules[module].file)
            }
            (Target::Module(_), _) => None,
        }
    }

    fn resolve(&self, from: usize, path: &[String], imports_left: usize) -> Option<Target> {
        let (first, mut rest) = path.split_first()?;
        let mut target = match first.as_str() {
            "crate" => Target::Module(self.root_of(from)),
            "self" => Target::Module(from),
            "super" => Target::Module(self.source.modules[from].parent?),
            name => self.name_in(from, name, !rest.is_empty(), imports_left)?,
        };
        while let (Target::Module(module), Some((name, after))) = (target, rest.split_first()) {
            target = if name == "super" {
                Target::Module(self.source.modules[module].parent?)
            } else {
                // What the text does not define is defined by a macro that is called there.
                self.name_in(module, name, !after.is_empty(), imports_left).unwrap_or(Target::Item(module))
            };
            rest = after;
        }
        Some(target)
    }

    /// What a name stands for in a module; a module rather than a function of the same name if the path goes
    /// on.
    fn name_in(&self, at: usize, name: &str, goes_on: bool, imports_left: usize) -> Option<Target> {
        let imports_left = imports_left.checked_sub(1)?;
        let module = &self.source.modules[at];
        let child = module.children.get(name).copied().map(Target::Module);
        if goes_on && child.is_some() {
            return child;
        }
        if module.items.contains(name) {
            return Some(Target::Item(at));
        }
        let (globs, named): (Vec<&Import>, Vec<&Import>) =
            module.imports.iter().partition(|import| import.is_glob);
        let named = named.into_iter().filter(|import| import.name.as_deref() == Some(name));
        // `use name::Thing as name` and `use name::*` do not bring the name that they begin with.
        let begins = |import: &Import| import.path[0] == name && child.is_none();
        let led = named
            .filter(|import| !begins(import))
            .find_map(|import| self.resolve(at, &import.path, imports_left));
        led.or(child).or_else(|| {
            let mut globs = globs.into_iter().filter(|import| !begins(import));
            globs.find_map(|import| match self.resolve(at, &import.path, imports_left)? {
                Target::Module(inside) if inside != at => self.name_in(inside, name, goes_on, imports_left),
                Target::Module(_) | Target::Item(_) => None,
            })
        })
    }

    fn root_of(&self, mut module: usize) -> usize {
        while let Some(parent) = self.source.modules[module].parent {
            module = parent;
        }
        module
    }
}
