//! Access control: the files that a document may make a program read and write.

use crate::{
    CheckedGraph, Diagnostic, DocumentPlace, FrameContext, Item, KnobType, Means, NodeId, OutputSpec, Severity,
};
use std::path::{Component, Path, PathBuf};

/// The files that a document may make a program read and write: whole folder trees, and single files.
///
/// A document may come from an untrusted source, and its author chose every path in it. Engines check access before a
/// stage prepares and before outputs are named, so a node cannot forget to.
///
/// ```
/// use std::path::Path;
/// use trochoid_graph::Access;
///
/// let access = Access::beneath(Path::new("shots/a"));
/// assert!(access.check(Path::new("shots/a/paint/skin.png")).is_ok());
/// assert!(access.check(Path::new("shots/a/../b/skin.png")).is_err());
/// assert!(access.allowing(Path::new("shots/b")).check(Path::new("shots/a/../b/skin.png")).is_ok());
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Access {
    /// Allowed paths; `None` allows everything.
    roots: Option<Vec<Root>>,
    overwrites: bool,
}

/// A folder tree or a file, and the rights on it.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Root {
    /// Resolved path.
    path: PathBuf,
    rights: &'static [Right],
}

/// A right to a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Right {
    /// The right to read the file.
    Read,
    /// The right to write the file.
    Write,
}

impl Right {
    const BOTH: &[Self] = &[Self::Read, Self::Write];

    fn alone(self) -> &'static [Self] {
        match self {
            Self::Read => &[Self::Read],
            Self::Write => &[Self::Write],
        }
    }
}

impl Root {
    fn new(path: &Path, rights: &'static [Right]) -> Self {
        Self { path: resolved(path), rights }
    }
}

/// A path that leads outside of what a document may reach.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AccessViolation {
    /// Target of the path: absolute, with links followed.
    pub leads_to: PathBuf,
    /// Allowed folders and files.
    pub allowed: Vec<PathBuf>,
}

impl AccessViolation {
    /// Returns the folder that has to be allowed.
    pub fn folder(&self) -> &Path {
        self.leads_to.parent().unwrap_or(&self.leads_to)
    }

    /// Returns what was expected: the folders and files that are allowed, in words.
    pub fn expected(&self) -> String {
        let allowed: Vec<String> = self.allowed.iter().map(|root| root.display().to_string()).collect();
        format!("a file that the document may reach, beneath {}", allowed.join(", "))
    }
}

/// Remedy of one refused file.
pub(crate) const ALLOW: &str = "allow it if you trust the document";
/// Remedy of several.
const ALLOW_ALL: &str = "allow them if you trust the document";

/// Returns the faults of files that a document may not reach; the remedy of each allows all of them.
pub fn refusals(refused: &[RefusedFile]) -> Vec<Diagnostic> {
    let remedy = if refused.len() == 1 { ALLOW } else { ALLOW_ALL };
    let means = Means::Allow(refused.iter().map(|refused| refused.outside.clone()).collect());
    let fault = |refused: &RefusedFile| Diagnostic {
        remedy: remedy.into(),
        means: Some(means.clone()),
        used: None,
        ..refused.diagnostic()
    };
    refused.iter().map(fault).collect()
}

/// Returns the folders that have to be allowed for some paths, each once, without folders beneath others.
pub fn folders_to_allow<'o>(paths: impl IntoIterator<Item = &'o AccessViolation>) -> Vec<&'o Path> {
    let folders: Vec<&Path> = paths.into_iter().map(AccessViolation::folder).collect();
    let mut named: Vec<&Path> = Vec::new();
    for folder in &folders {
        let is_beneath = |other: &&Path| folder.starts_with(other) && folder != other;
        if !folders.iter().any(is_beneath) && !named.contains(folder) {
            named.push(folder);
        }
    }
    named
}

impl std::fmt::Display for AccessViolation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "found the file {}; expected {}; {ALLOW}", self.leads_to.display(), self.expected())
    }
}

impl Access {
    /// Allows the files beneath one folder: for servers, which cannot trust documents.
    pub fn beneath(folder: &Path) -> Self {
        Self { roots: Some(vec![Root::new(folder, Right::BOTH)]), overwrites: false }
    }

    /// Allows the files beneath a document's folder and, if that lies beneath the current folder, beneath the current
    /// folder. This is the default for graphs.
    ///
    /// The root of the file system does not count as a current folder, since it is the one of services.
    pub fn usual(folder: &Path) -> Self {
        let own = Root::new(folder, Right::BOTH);
        let current = Root::new(Path::new("."), Right::BOTH);
        let holds = own.path.starts_with(&current.path) && current.path.parent().is_some() && own != current;
        Self { roots: Some([own].into_iter().chain(holds.then_some(current)).collect()), overwrites: false }
    }

    /// Allows every file: for documents that are trusted like programs.
    pub fn everything() -> Self {
        Self { roots: None, overwrites: false }
    }

    /// Also allows reading and writing a file or a folder tree.
    #[must_use]
    pub fn allowing(self, path: &Path) -> Self {
        self.with(path, Right::BOTH)
    }

    /// Also allows a file or a folder tree for one right only.
    #[must_use]
    pub fn granting(self, path: &Path, right: Right) -> Self {
        self.with(path, right.alone())
    }

    fn with(mut self, path: &Path, rights: &'static [Right]) -> Self {
        if let Some(roots) = &mut self.roots {
            roots.push(Root::new(path, rights));
        }
        self
    }

    /// Sets whether files that Trochoid did not write may be replaced.
    #[must_use]
    pub fn overwriting(self, overwrites: bool) -> Self {
        Self { overwrites, ..self }
    }

    /// Whether files that Trochoid did not write may be replaced.
    pub fn overwrites(&self) -> bool {
        self.overwrites
    }

    /// Checks whether a path, which need not exist, may be read.
    ///
    /// # Errors
    /// The path leads outside.
    pub fn check(&self, path: &Path) -> Result<(), AccessViolation> {
        self.check_for(path, Right::Read)
    }

    /// Checks whether a path, which need not exist, may be used with a right.
    ///
    /// # Errors
    /// The path leads outside.
    pub fn check_for(&self, path: &Path, right: Right) -> Result<(), AccessViolation> {
        let Some(roots) = &self.roots else { return Ok(()) };
        let leads_to = resolved(path);
        let roots: Vec<&PathBuf> =
            roots.iter().filter(|root| root.rights.contains(&right)).map(|root| &root.path).collect();
        if roots.iter().any(|root| leads_to.starts_with(root)) {
            return Ok(());
        }
        Err(AccessViolation { leads_to, allowed: roots.into_iter().cloned().collect() })
    }
}

/// Largest number of links that are followed in one path.
const MOST_LINKS: usize = 40;

/// Returns the target of a path: absolute, with links followed and each `..` applied to the components before it.
/// Components that do not exist yet count as folders that will be made.
pub fn resolved(path: &Path) -> PathBuf {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    if let Ok(whole) = path.canonicalize() {
        return whole;
    }
    // The most frequent case is a new file in an existing folder, for which two system calls suffice.
    if let (Some(folder), Some(name)) = (path.parent(), path.file_name()) {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        if let Ok(folder) = folder.canonicalize()
            && folder.join(name).symlink_metadata().is_err()
        {
            return folder.join(name);
        }
    }
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.into());
    let mut links = 0;
    follow(PathBuf::new(), &absolute, &mut links)
}

/// Resolves a path from a resolved folder.
fn follow(mut at: PathBuf, path: &Path, links: &mut usize) -> PathBuf {
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                at.pop();
            }
            Component::Prefix(_) | Component::RootDir => at.push(part),
            Component::Normal(name) => {
                let next = at.join(name);
                at = match next.canonicalize() {
                    Ok(whole) => whole,
                    // A dangling link: a file would be made at its target.
                    Err(_) => match next.read_link() {
                        Ok(target) if *links < MOST_LINKS => {
                            *links += 1;
                            follow(at, &target, links)
                        }
                        _ => next,
                    },
                };
            }
        }
    }
    at
}

/// A file that a document names but may not reach.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusedFile {
    /// Name of the document.
    pub document: String,
    /// Node that would read the file; `None` for the file of an output.
    pub node: Option<String>,
    /// Knob or output that names the file; `None` if another file that the node reads names it.
    pub item: Option<String>,
    /// Line and column in the document.
    pub place: [usize; 2],
    /// Path as written, with the frame filled in.
    pub path: PathBuf,
    /// Target of the path, and the allowed paths.
    pub outside: AccessViolation,
}

impl std::error::Error for RefusedFile {}

impl RefusedFile {
    /// Returns the fault, with its place in the document and the remedy.
    pub fn diagnostic(&self) -> Diagnostic {
        let [line, column] = self.place;
        Diagnostic {
            severity: Severity::Error,
            file: self.document.clone(),
            is_assigned: false,
            line,
            column,
            node: self.node.clone(),
            port: self.item.clone(),
            found: self.found(),
            expected: self.outside.expected(),
            remedy: ALLOW.into(),
            means: Some(Means::Allow(vec![self.outside.clone()])),
            used: None,
        }
    }

    /// Returns the right that the document needs.
    pub fn right(&self) -> Right {
        if self.node.is_some() { Right::Read } else { Right::Write }
    }

    /// Returns what was found: the file as named, and where it leads, in words.
    pub fn found(&self) -> String {
        let (path, leads_to) = (self.path.display(), self.outside.leads_to.display());
        let same = self.path == self.outside.leads_to;
        if same { format!("the file {path}") } else { format!("the file {path}, which leads to {leads_to}") }
    }
}

/// Formats what was found, what was expected and what to do, like messages of nodes.
impl std::fmt::Display for RefusedFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "found {}; expected {}; {ALLOW}", self.found(), self.outside.expected())
    }
}

impl CheckedGraph {
    /// Returns the files that the document may reach.
    pub fn access(&self) -> &Access {
        &self.access
    }

    /// Sets the files that the document may reach; the default is [`Access::usual`] of its folder. Files that are
    /// named by assignments outside of the document are always allowed.
    #[must_use]
    pub fn with_access(mut self, access: Access) -> Self {
        self.access = access;
        self
    }

    /// Returns the first file that a node would read at a frame but may not; engines check this before the node
    /// prepares.
    pub fn refused(&self, id: NodeId, context: &FrameContext) -> Option<RefusedFile> {
        let node = self.node(id);
        let settled = self.settle(id, context.frame);
        let mut trusted = Vec::new();
        let mut named = Vec::new();
        for item in node.ty.declaration().items {
            let Item::Knob(knob) = item else { continue };
            if !matches!(knob.takes, KnobType::Path) || !settled.is_set(knob.name) {
                continue;
            }
            let path = context.path(settled.text(knob.name));
            if node.is_assigned(knob.name) {
                trusted.push(path);
            } else {
                named.push((Some(knob.name), path));
            }
        }
        named.extend(self.files_of(id, context).into_iter().map(|path| (None, path)));
        let mut open = named.into_iter().filter(|(_, path)| !trusted.contains(path));
        open.find_map(|(item, path)| {
            let outside = self.access.check(&path).err()?;
            let DocumentPlace { document, line, column } = item.map_or(&node.place, |item| node.place_of(item)).clone();
            let (node, item) = (Some(node.name.clone()), item.map(String::from));
            Some(RefusedFile { document: document.to_string(), node, item, place: [line, column], path, outside })
        })
    }

    /// Checks whether an output may be written to the path that the document itself names.
    ///
    /// # Errors
    /// The path leads outside of what the document may reach.
    pub fn check_written(&self, output: &OutputSpec, path: &Path) -> Result<(), Box<RefusedFile>> {
        self.access.check_for(path, Right::Write).map_err(|outside| {
            Box::new(RefusedFile {
                document: self.name.clone(),
                node: None,
                item: Some(format!("output \"{}\", file", output.name)),
                place: output.place,
                path: path.into(),
                outside,
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn folder() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().canonicalize().expect("there");
        (folder, path)
    }

    #[test]
    fn each_folder_is_to_be_allowed_once_and_none_beneath_another() {
        let outside = |path: &str| AccessViolation { leads_to: path.into(), allowed: Vec::new() };
        let paths = ["/a b/x.png", "/c/d/y.png", "/c/z.png", "/c/z2.png", "/e/x"].map(outside);
        assert_eq!(folders_to_allow(&paths), ["/a b", "/c", "/e"].map(Path::new));
    }

    #[test]
    fn dots_and_what_does_not_exist_yet_are_resolved() {
        let (_held, root) = folder();
        fs::create_dir_all(root.join("a/b")).expect("made");
        let access = Access::beneath(&root.join("a"));
        for inside in ["a/x.png", "a/b/../x.png", "a/new/deep/x.png", "a/new/../x.png", "a/./b", "a", "b/../a/x"] {
            assert!(access.check(&root.join(inside)).is_ok(), "{inside}");
        }
        for outside in ["x.png", "a/../x.png", "a/new/../../x.png", "ab/x.png", "a/b/../../../x", "../x", "."] {
            let refused = access.check(&root.join(outside)).expect_err(outside);
            assert!(refused.leads_to.is_absolute() && !refused.leads_to.starts_with(root.join("a")), "{refused:?}");
        }
        assert!(access.check(Path::new("/")).is_err());
        assert!(Access::everything().check(Path::new("/etc/passwd")).is_ok());
    }

    #[test]
    fn a_folder_that_is_not_there_yet_and_a_file_are_allowed() {
        let (_held, root) = folder();
        let access =
            Access::beneath(&root.join("a")).allowing(&root.join("new/folder")).allowing(&root.join("one.png"));
        assert!(access.check(&root.join("new/folder/x.png")).is_ok());
        assert!(access.check(&root.join("one.png")).is_ok());
        for outside in ["new/x.png", "one.png.exr", "two.png"] {
            assert!(access.check(&root.join(outside)).is_err(), "{outside}");
        }
    }

    #[test]
    fn what_may_be_read_may_not_be_written_and_the_other_way() {
        let (_held, root) = folder();
        let access = Access::beneath(&root.join("a"))
            .granting(&root.join("in"), Right::Read)
            .granting(&root.join("out"), Right::Write)
            .allowing(&root.join("both"));
        for (path, reads, writes) in
            [("a/x", true, true), ("in/x", true, false), ("out/x", false, true), ("both/x", true, true)]
        {
            let may = [Right::Read, Right::Write].map(|right| access.check_for(&root.join(path), right).is_ok());
            assert_eq!(may, [reads, writes], "{path}");
        }
        let refused = access.check_for(&root.join("in/x"), Right::Write).expect_err("read only");
        assert_eq!(refused.allowed, [root.join("a"), root.join("out"), root.join("both")]);
    }

    #[cfg(unix)]
    #[test]
    fn links_count_by_where_they_lead() {
        use std::os::unix::fs::symlink;
        let (_held, root) = folder();
        for name in ["a", "elsewhere", "a/b"] {
            fs::create_dir_all(root.join(name)).expect("made");
        }
        fs::write(root.join("elsewhere/secret"), "").expect("written");
        symlink(root.join("elsewhere"), root.join("a/out")).expect("a link");
        symlink("../elsewhere/secret", root.join("a/file")).expect("a link");
        symlink("../elsewhere/not_yet", root.join("a/dangling")).expect("a link");
        symlink("b", root.join("a/within")).expect("a link");
        symlink("loop", root.join("a/loop")).expect("a link");
        symlink(root.join("a"), root.join("alias")).expect("a link");
        let access = Access::beneath(&root.join("a"));
        for outside in
            ["a/out/x", "a/out/secret", "a/file", "a/dangling", "a/out/new/x", "a/within/../../x", "a/out/.."]
        {
            assert!(access.check(&root.join(outside)).is_err(), "{outside}");
        }
        for inside in ["a/within/x", "a/within/../x", "alias/x", "a/loop"] {
            assert!(access.check(&root.join(inside)).is_ok(), "{inside}");
        }
        // The allowed path may itself contain a link.
        assert!(Access::beneath(&root.join("alias")).check(&root.join("a/x")).is_ok());
    }
}
