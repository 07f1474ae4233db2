//! Where results go: the standard output, whose reader may leave, and files, which appear whole or not at all.

use crate::failure::Failure;
use std::fs::{File, OpenOptions};
use std::io::{self, StdoutLock, Write};
use std::path::{Path, PathBuf};

/// The standard output of a command that ends with a verdict: when its reader leaves, what is left to say is dropped, and the exit
/// code stays the verdict's.
pub(crate) struct Verdicts<W = StdoutLock<'static>> {
    out: W,
    is_unheard: bool,
}

impl Verdicts {
    pub(crate) fn new() -> Self {
        Verdicts { out: io::stdout().lock(), is_unheard: false }
    }
}

impl<W: Write> Verdicts<W> {
    fn unless_unheard<T>(&mut self, otherwise: T, write: impl FnOnce(&mut W) -> io::Result<T>) -> io::Result<T> {
        if self.is_unheard {
            return Ok(otherwise);
        }
        match write(&mut self.out) {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {
                self.is_unheard = true;
                Ok(otherwise)
            }
            result => result,
        }
    }
}

impl<W: Write> Write for Verdicts<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.unless_unheard(bytes.len(), |out| out.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.unless_unheard((), W::flush)
    }
}

/// Says on the standard error what is wrong. Where nobody reads that there is nobody to tell, and the exit code says it too.
pub(crate) fn complain(what: &dyn std::fmt::Display) {
    let _ = writeln!(io::stderr(), "brdf: {what}");
}

/// A file to be written when what goes into it is there: tried at once, so that nobody waits for what cannot be kept.
#[derive(Debug)]
pub(crate) struct Destination {
    path: PathBuf,
}

impl Destination {
    /// Tries whether the file can be written, and leaves what is there as it is.
    pub(crate) fn new(path: &Path) -> Result<Self, Failure> {
        let destination = Destination { path: path.to_owned() };
        let tried = if path.is_dir() {
            Err(io::Error::from(io::ErrorKind::IsADirectory))
        } else if is_named_pipe(path) {
            Err(io::Error::other("is a named pipe, which may have no reader: name a file, or /dev/stdout"))
        } else if destination.is_stream() {
            OpenOptions::new().write(true).open(path).map(drop)
        } else {
            let partial = destination.partial();
            File::create(&partial).map(drop).and_then(|()| std::fs::remove_file(&partial))
        };
        tried.map_err(|error| destination.failure(&error))?;
        Ok(destination)
    }

    /// Writes each file to its end under another name, and only then gives all of them theirs.
    pub(crate) fn write_all(files: &[(&Destination, String)]) -> Result<(), Failure> {
        let written = files.iter().try_for_each(|(destination, text)| destination.prepare(text));
        let named = written.and_then(|()| {
            files.iter().filter(|(destination, _)| !destination.is_stream()).try_for_each(|(destination, _)| {
                // A link to a file stays one: the file is replaced.
                let end = std::fs::canonicalize(&destination.path).unwrap_or_else(|_| destination.path.clone());
                std::fs::rename(destination.partial(), end).map_err(|error| destination.failure(&error))
            })
        });
        if named.is_err() {
            for (destination, _) in files {
                let _ = std::fs::remove_file(destination.partial());
            }
        }
        named
    }

    fn prepare(&self, text: &str) -> Result<(), Failure> {
        let written = if self.is_stream() {
            OpenOptions::new().write(true).open(&self.path).and_then(|mut file| file.write_all(text.as_bytes()))
        } else {
            File::create(self.partial()).and_then(|mut file| {
                file.write_all(text.as_bytes())?;
                file.sync_all()
            })
        };
        written.map_err(|error| self.failure(&error))
    }

    /// Whether the name is that of something which takes bytes and is no file: a device, a pipe.
    fn is_stream(&self) -> bool {
        self.path.metadata().is_ok_and(|about| !about.is_file() && !about.is_dir())
    }

    /// A name beside the file's own that no other process writes to.
    fn partial(&self) -> PathBuf {
        let end = std::fs::canonicalize(&self.path).unwrap_or_else(|_| self.path.clone());
        let mut name = end.file_name().unwrap_or_default().to_os_string();
        name.push(format!(".{}.partial", std::process::id()));
        end.with_file_name(name)
    }

    fn failure(&self, error: &io::Error) -> Failure {
        format!("{}: {error}", self.path.display()).into()
    }
}

/// Whether opening it waits until somebody else does. What /dev leads to is open already.
#[cfg(unix)]
fn is_named_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    !path.starts_with("/dev") && path.metadata().is_ok_and(|about| about.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_named_pipe(_: &Path) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes some bytes, then is gone.
    struct Leaving(usize);

    impl Write for Leaving {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let taken = bytes.len().min(self.0);
            self.0 -= taken;
            if taken > 0 { Ok(taken) } else { Err(io::ErrorKind::BrokenPipe.into()) }
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_leaves_is_no_error() {
        let mut out = Verdicts { out: Leaving(3), is_unheard: false };
        assert!(out.write_all(b"more than three").is_ok() && out.flush().is_ok());
        assert!(out.is_unheard);
    }

    #[test]
    fn files_are_tried_first_and_written_whole() {
        let folder = std::env::temp_dir().join(format!("brdf-output-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let (first, second) = (folder.join("first"), folder.join("second"));
        std::fs::write(&first, "old").expect("written");
        let [a, b] = [&first, &second].map(|path| Destination::new(path).expect("it can be written"));
        assert_eq!(std::fs::read_dir(&folder).expect("a folder").count(), 1, "trying leaves nothing behind");
        // What was a file to be is a folder now.
        std::fs::create_dir(&second).expect("a folder");
        std::fs::write(second.join("x"), "").expect("written");
        assert!(Destination::write_all(&[(&a, "new".into()), (&b, "new".into())]).is_err());
        assert!(Destination::new(&second).is_err() && Destination::new(&folder.join("no/file")).is_err());
        std::fs::remove_dir_all(&second).expect("removed");
        Destination::write_all(&[(&a, "new".into()), (&b, "newer".into())]).expect("written");
        let text = |path: &Path| std::fs::read_to_string(path).expect("read");
        assert_eq!((text(&first).as_str(), text(&second).as_str()), ("new", "newer"));
        assert_eq!(std::fs::read_dir(&folder).expect("a folder").count(), 2);
        let _ = std::fs::remove_dir_all(&folder);
    }
}
