//! Reads the modules of a crate from its source text, without a compiler: what each module defines, what it
//! imports, and which paths its code mentions.
//!
//! The text is cut into tokens by `proc-macro2`, so that strings and comments are out of the way and the
//! arguments of macros are seen like other code (a syntax tree would hide them). What tests alone compile is
//! left out.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use anyhow::{Context as _, anyhow};
use proc_macro2::{Delimiter, Group, Ident, TokenStream, TokenTree};

/// The texts of a crate, by path relative to its `src`.
pub(crate) type Texts = BTreeMap<PathBuf, String>;

/// A module: a file of its own or a block within one.
pub(crate) struct Module {
    pub(crate) file: PathBuf,
    pub(crate) parent: Option<usize>,
    pub(crate) children: BTreeMap<String, usize>,
    /// Functions, types, traits, constants and statics defined here by the text itself (not by a macro).
    pub(crate) items: BTreeSet<String>,
    pub(crate) imports: Vec<Import>,
    /// Folder in which the files of children lie.
    folder: PathBuf,
}

/// One leaf of a `use` declaration.
pub(crate) struct Import {
    /// The name it gets here; none for `*` and `_`.
    pub(crate) name: Option<String>,
    pub(crate) path: Vec<String>,
    pub(crate) is_glob: bool,
}

/// Code that names something.
pub(crate) struct Mention {
    pub(crate) module: usize,
    pub(crate) path: Vec<String>,
    pub(crate) line: usize,
    pub(crate) kind: MentionKind,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum MentionKind {
    /// Something inside a module, a type or nothing of this crate.
    Path,
    /// `module::{…}` outside of a `use`, or a module whose items a macro names: the path itself is the module
    /// that is used.
    Inside,
    /// `name!`
    Macro,
}

/// What a crate's text says.
#[derive(Default)]
pub(crate) struct Source {
    /// The first one is the crate's root.
    pub(crate) modules: Vec<Module>,
    pub(crate) mentions: Vec<Mention>,
    /// Files in which `macro_rules` defines a name.
    pub(crate) macros: BTreeMap<String, PathBuf>,
}

impl Source {
    /// Reads the crate whose root is `root`, for instance `lib.rs`.
    pub(crate) fn read(texts: &Texts, root: &Path) -> anyhow::Result<Self> {
        let mut reader = Reader { texts, source: Self::default(), declaring: BTreeMap::new() };
        reader.module_in_file(root, None, PathBuf::new())?;
        Ok(reader.source)
    }

    /// All files that belong to the crate, its root first.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let mut files: Vec<PathBuf> = Vec::new();
        for module in &self.modules {
            if !files.contains(&module.file) {
                files.push(module.file.clone());
            }
        }
        files
    }
}

/// A `macro_rules` that declares a module for a name it is given.
#[derive(Clone, Copy)]
struct Declaring {
    /// Whether it also names what these modules hold (`$module::…`).
    names_items: bool,
}

struct Reader<'a> {
    texts: &'a Texts,
    source: Source,
    declaring: BTreeMap<String, Declaring>,
}

impl Reader<'_> {
    fn module_in_file(
        &mut self,
        file: &Path,
        parent: Option<usize>,
        folder: PathBuf,
    ) -> anyhow::Result<usize> {
        let text =
            self.texts.get(file).with_context(|| format!("{} is declared but missing", file.display()))?;
        let tokens: TokenStream = text.parse().map_err(|error| anyhow!("{}: {error}", file.display()))?;
        let module = self.add_module(file, parent, folder);
        self.scope(tokens, module)?;
        Ok(module)
    }

    fn add_module(&mut self, file: &Path, parent: Option<usize>, folder: PathBuf) -> usize {
        self.source.modules.push(Module {
            file: file.to_owned(),
            parent,
            children: BTreeMap::new(),
            items: BTreeSet::new(),
            imports: Vec::new(),
            folder,
        });
        self.source.modules.len() - 1
    }

    /// Reads the tokens directly inside a module: items stand here.
    fn scope(&mut self, tokens: TokenStream, module: usize) -> anyhow::Result<()> {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        let mut path_attribute = None;
        while at < tokens.len() {
            if let Some(attribute) = Attribute::at(&tokens, at) {
                at = attribute.end;
                if attribute.for_tests_only {
                    if attribute.is_inner {
                        return Ok(());
                    }
                    at = end_of_item(&tokens, at);
                } else if attribute.path.is_some() {
                    path_attribute = attribute.path;
                }
                continue;
            }
            at = match (word(&tokens, at).as_deref(), word(&tokens, at + 1)) {
                (Some("mod"), Some(name)) => {
                    self.child(&tokens, at, &name, path_attribute.take(), module)?;
                    at + 3
                }
                (Some("macro_rules"), _) => {
                    self.macro_rules(&tokens, at, module);
                    at + 4
                }
                (Some("fn" | "struct" | "enum" | "union" | "trait" | "type"), Some(name)) => {
                    self.source.modules[module].items.insert(name);
                    at + 2
                }
                (Some("const" | "static"), Some(name)) if name != "fn" && name != "unsafe" => {
                    let is_mutable = name == "mut";
                    let name = if is_mutable { word(&tokens, at + 2).unwrap_or_default() } else { name };
                    self.source.modules[module].items.insert(name);
                    at + 2
                }
                (Some(name), _) if self.declaring.contains_key(name) && is_punct(&tokens, at + 1, '!') => {
                    let declaring = self.declaring[name];
                    self.declared_by_macro(&tokens, at, declaring, module)?;
                    self.step(&tokens, at, module)
                }
                _ => self.step(&tokens, at, module),
            };
        }
        Ok(())
    }

    /// `mod name;` or `mod name { … }` at `at`.
    fn child(
        &mut self,
        tokens: &[TokenTree],
        at: usize,
        name: &str,
        path_attribute: Option<String>,
        module: usize,
    ) -> anyhow::Result<()> {
        let parent = &self.source.modules[module];
        let folder = parent.folder.join(name);
        let child = match tokens.get(at + 2) {
            Some(TokenTree::Group(block)) => {
                let file = parent.file.clone();
                let child = self.add_module(&file, Some(module), folder);
                self.scope(block.stream(), child)?;
                child
            }
            _ => match path_attribute {
                // The attribute counts from the folder of the declaring file (Rust reference, "The path
                // attribute").
                Some(path) => {
                    let file = parent.file.parent().unwrap_or(Path::new("")).join(path);
                    let folder = file.parent().unwrap_or(Path::new("")).to_owned();
                    self.module_in_file(&file, Some(module), folder)?
                }
                None => self.child_file(folder, module)?.with_context(|| {
                    format!(
                        "{} declares `mod {name}` without a file",
                        self.source.modules[module].file.display()
                    )
                })?,
            },
        };
        self.source.modules[module].children.insert(name.to_owned(), child);
        Ok(())
    }

    /// Reads `folder.rs` or `folder/mod.rs`, whichever there is.
    fn child_file(&mut self, folder: PathBuf, module: usize) -> anyhow::Result<Option<usize>> {
        for file in [folder.with_extension("rs"), folder.join("mod.rs")] {
            if self.texts.contains_key(&file) {
                return self.module_in_file(&file, Some(module), folder).map(Some);
            }
        }
        Ok(None)
    }

    /// The call of a macro that declares modules: those of its arguments that have a file.
    fn declared_by_macro(
        &mut self,
        tokens: &[TokenTree],
        at: usize,
        declaring: Declaring,
        module: usize,
    ) -> anyhow::Result<()> {
        let Some(TokenTree::Group(arguments)) = tokens.get(at + 2) else { return Ok(()) };
        for ident in idents(arguments.stream()) {
            let name = ident.to_string();
            if self.source.modules[module].children.contains_key(&name) {
                continue;
            }
            let folder = self.source.modules[module].folder.join(&name);
            let Some(child) = self.child_file(folder, module)? else { continue };
            self.source.modules[module].children.insert(name.clone(), child);
            if declaring.names_items {
                let path = vec!["self".to_owned(), name];
                self.mention(module, path, ident.span().start().line, MentionKind::Inside);
            }
        }
        Ok(())
    }

    /// `macro_rules! name { … }` at `at`. Paths in its rules count for the file that writes them.
    fn macro_rules(&mut self, tokens: &[TokenTree], at: usize, module: usize) {
        let (Some(name), Some(TokenTree::Group(rules))) = (word(tokens, at + 2), tokens.get(at + 3)) else {
            return;
        };
        let flat = flatten(rules.stream());
        let declares = (0..flat.len()).any(|at| is_word(&flat, at, "mod") && is_punct(&flat, at + 1, '$'));
        if declares {
            let is_path = |at: usize| {
                is_punct(&flat, at, '$') && word(&flat, at + 1).is_some() && is_colons(&flat, at + 2)
            };
            // The pattern may separate two names by colons as well; there a kind follows each name, with one
            // colon.
            let names_items = (0..flat.len()).any(is_path);
            self.declaring.insert(name.clone(), Declaring { names_items });
        }
        self.source.macros.insert(name, self.source.modules[module].file.clone());
        self.body(rules.stream(), module);
    }

    /// Reads tokens that are not directly inside a module: bodies, fields, arguments.
    fn body(&mut self, tokens: TokenStream, module: usize) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        while at < tokens.len() {
            at = match Attribute::at(&tokens, at) {
                Some(attribute) if attribute.for_tests_only && !attribute.is_inner => {
                    end_of_item(&tokens, attribute.end)
                }
                Some(attribute) => attribute.end,
                None if is_word(&tokens, at, "macro_rules") && is_punct(&tokens, at + 1, '!') => {
                    self.macro_rules(&tokens, at, module);
                    at + 4
                }
                None => self.step(&tokens, at, module),
            };
        }
    }

    /// Reads what may stand anywhere: a `use`, a path, a group. Returns where to go on.
    fn step(&mut self, tokens: &[TokenTree], at: usize, module: usize) -> usize {
        match &tokens[at] {
            TokenTree::Group(group) => {
                self.body(group.stream(), module);
                at + 1
            }
            // `use<…>` names what a return type captures.
            TokenTree::Ident(ident) if ident == "use" && !is_punct(tokens, at + 1, '<') => {
                let length = tokens[at..].iter().position(is_semicolon);
                let end = length.map_or(tokens.len(), |length| at + length);
                let is_public = at > 0
                    && (is_word(tokens, at - 1, "pub")
                        || matches!(&tokens[at - 1], TokenTree::Group(group) if group.delimiter() == Delimiter::Parenthesis)
                            && at > 1
                            && is_word(tokens, at - 2, "pub"));
                self.use_tree(&tokens[at + 1..end], &[], is_public, module);
                end + 1
            }
            TokenTree::Ident(_) => self.path(tokens, at, module),
            _ => at + 1,
        }
    }

    /// The tree of a `use` declaration. A re-export names nothing itself: who uses it is led to the
    /// definition.
    fn use_tree(&mut self, tokens: &[TokenTree], prefix: &[String], is_public: bool, module: usize) {
        for tree in tokens.split(|token| matches!(token, TokenTree::Punct(punct) if punct.as_char() == ',')) {
            let mut path = prefix.to_vec();
            let mut renamed = None;
            let mut at = 0;
            let mut is_leaf = true;
            let mut is_glob = false;
            let mut line = 0;
            while at < tree.len() {
                match &tree[at] {
                    TokenTree::Ident(ident) if ident == "as" => {
                        renamed = word(tree, at + 1);
                        break;
                    }
                    TokenTree::Ident(ident) => {
                        line = ident.span().start().line;
                        path.push(plain(ident));
                    }
                    TokenTree::Group(group) => {
                        let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                        self.use_tree(&inner, &path, is_public, module);
                        is_leaf = false;
                    }
                    TokenTree::Punct(punct) if punct.as_char() == '*' => {
                        line = punct.span().start().line;
                        is_glob = true;
                    }
                    _ => {}
                }
                at += 1;
            }
            if !is_leaf || path.is_empty() {
                continue;
            }
            // `a::b::{self}` is `a::b`.
            if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
                path.pop();
            }
            let name = renamed.or_else(|| path.last().cloned()).filter(|name| !is_glob && name != "_");
            if !is_public {
                let kind = if is_glob { MentionKind::Inside } else { MentionKind::Path };
                self.mention(module, path.clone(), line, kind);
            }
            self.source.modules[module].imports.push(Import { name, path, is_glob });
        }
    }

    /// A path, perhaps of one name, in code.
    fn path(&mut self, tokens: &[TokenTree], start: usize, module: usize) -> usize {
        let TokenTree::Ident(first) = &tokens[start] else { return start + 1 };
        let mut segments = vec![plain(first)];
        let mut at = start + 1;
        while is_colons(tokens, at) {
            let Some(segment) = word(tokens, at + 2) else { break };
            segments.push(segment);
            at += 3;
        }
        // Fields, methods, lifetimes and what goes on from a type or a placeholder of a macro are no names of
        // items.
        let before = start.checked_sub(1).map(|at| &tokens[at]);
        let is_range = start > 1 && is_punct(tokens, start - 2, '.');
        let is_placeholder = start > 0 && is_punct(tokens, start - 1, '$') && first != "crate";
        let is_continuation = match before {
            Some(TokenTree::Punct(punct)) => match punct.as_char() {
                '.' => !is_range,
                ':' => start > 1 && is_colons(tokens, start - 2),
                '\'' => true,
                _ => is_placeholder,
            },
            // What is being defined.
            Some(TokenTree::Ident(keyword)) => keyword == "fn",
            _ => false,
        };
        if is_continuation {
            return at;
        }
        let is_macro = is_punct(tokens, at, '!') && !is_punct(tokens, at + 1, '=');
        let calls = matches!(tokens.get(at), Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis);
        let opens = is_colons(tokens, at)
            && matches!(tokens.get(at + 2), Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace);
        let kind = match (is_macro, opens) {
            (true, _) => MentionKind::Macro,
            (false, true) => MentionKind::Inside,
            (false, false) => MentionKind::Path,
        };
        // A single small word that is not called is a variable far more often than an item.
        let is_telling = segments.len() > 1
            || kind != MentionKind::Path
            || calls
            || segments[0].starts_with(|initial: char| initial.is_uppercase());
        if is_telling {
            self.mention(module, segments, first.span().start().line, kind);
        }
        at
    }

    fn mention(&mut self, module: usize, path: Vec<String>, line: usize, kind: MentionKind) {
        self.source.mentions.push(Mention { module, path, line, kind });
    }
}

/// `#[…]` or `#![…]`.
struct Attribute {
    end: usize,
    is_inner: bool,
    for_tests_only: bool,
    /// The value of `path = "…"`.
    path: Option<String>,
}

impl Attribute {
    fn at(tokens: &[TokenTree], at: usize) -> Option<Self> {
        if !is_punct(tokens, at, '#') {
            return None;
        }
        let is_inner = is_punct(tokens, at + 1, '!');
        let bracket = at + 1 + usize::from(is_inner);
        let Some(TokenTree::Group(group)) = tokens.get(bracket) else { return None };
        if group.delimiter() != Delimiter::Bracket {
            return None;
        }
        let inner: Vec<TokenTree> = group.stream().into_iter().collect();
        let for_tests_only = match (word(&inner, 0).as_deref(), inner.get(1)) {
            (Some("test" | "bench"), None) => true,
            (Some("cfg"), Some(TokenTree::Group(condition))) => needs_test(condition),
            _ => false,
        };
        let path = match (word(&inner, 0).as_deref(), inner.get(2)) {
            (Some("path"), Some(TokenTree::Literal(text))) => {
                Some(text.to_string().trim_matches('"').to_owned())
            }
            _ => None,
        };
        Some(Self { end: bracket + 1, is_inner, for_tests_only, path })
    }
}

/// Whether a condition of `cfg` holds only in tests: `test`, `doctest` or `all(…)` with one of them.
fn needs_test(condition: &Group) -> bool {
    let tokens: Vec<TokenTree> = condition.stream().into_iter().collect();
    let mut terms = tokens.split(|token| matches!(token, TokenTree::Punct(punct) if punct.as_char() == ','));
    terms.any(|term| match (word(term, 0).as_deref(), term.get(1)) {
        (Some("test" | "doctest"), None) => true,
        (Some("all"), Some(TokenTree::Group(inner))) => needs_test(inner),
        _ => false,
    })
}

/// Where the item, field, arm or statement that begins at `at` ends.
fn end_of_item(tokens: &[TokenTree], mut at: usize) -> usize {
    while let Some(attribute) = Attribute::at(tokens, at) {
        at = attribute.end;
    }
    // These end at a semicolon and may hold braces before.
    let mut to_semicolon = false;
    let mut is_item = false;
    while at < tokens.len() {
        match &tokens[at] {
            TokenTree::Ident(ident) => match ident.to_string().as_str() {
                "use" | "static" | "type" | "let" if !is_item => (to_semicolon, is_item) = (true, true),
                "const" if !is_item && !is_word(tokens, at + 1, "fn") => {
                    (to_semicolon, is_item) = (true, true);
                }
                "fn" | "struct" | "enum" | "impl" | "trait" | "mod" | "macro_rules" => is_item = true,
                _ => {}
            },
            TokenTree::Punct(punct) if punct.as_char() == ';' || (punct.as_char() == ',' && !is_item) => {
                return at + 1;
            }
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace && !to_semicolon => {
                return at + 1;
            }
            _ => {}
        }
        at += 1;
    }
    at
}

/// All tokens, those within groups among them, without delimiters.
fn flatten(tokens: TokenStream) -> Vec<TokenTree> {
    tokens.into_iter().fold(Vec::new(), |mut flat, token| {
        match token {
            TokenTree::Group(group) => flat.extend(flatten(group.stream())),
            token => flat.push(token),
        }
        flat
    })
}

fn idents(tokens: TokenStream) -> Vec<Ident> {
    let ident = |token| match token {
        TokenTree::Ident(ident) => Some(ident),
        _ => None,
    };
    flatten(tokens).into_iter().filter_map(ident).collect()
}

fn plain(ident: &Ident) -> String {
    ident.to_string().trim_start_matches("r#").to_owned()
}

fn word(tokens: &[TokenTree], at: usize) -> Option<String> {
    match tokens.get(at) {
        Some(TokenTree::Ident(ident)) => Some(plain(ident)),
        _ => None,
    }
}

fn is_word(tokens: &[TokenTree], at: usize, expected: &str) -> bool {
    matches!(tokens.get(at), Some(TokenTree::Ident(ident)) if ident == expected)
}

fn is_punct(tokens: &[TokenTree], at: usize, expected: char) -> bool {
    matches!(tokens.get(at), Some(TokenTree::Punct(punct)) if punct.as_char() == expected)
}

fn is_semicolon(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == ';')
}

fn is_colons(tokens: &[TokenTree], at: usize) -> bool {
    is_punct(tokens, at, ':') && is_punct(tokens, at + 1, ':')
}
