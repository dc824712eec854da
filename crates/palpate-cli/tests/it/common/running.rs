//! The program in a child process that is killed when the test ends: a leftover loop would slow down every following
//! test.

use std::ops::{Deref, DerefMut};
use std::process::{Child, Command, Output};

use super::Folder;

/// The program, running.
pub struct Running(Option<Child>);

/// Returns the command of the program in a folder, with arguments separated by blanks.
pub fn program(folder: &Folder, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_palpate"));
    command
        .args(arguments.split(' '))
        .current_dir(folder.path("."));
    command
}

impl Running {
    pub fn start(command: &mut Command) -> Self {
        Self(Some(command.spawn().unwrap()))
    }

    /// Sends it a signal, by its name without SIG.
    pub fn signal(&self, name: &str) {
        let status = Command::new("kill")
            .args([format!("-{name}"), self.id().to_string()])
            .status();
        assert!(status.unwrap().success(), "{name}");
    }

    /// Waits for its end. Returns its remaining output.
    pub fn output(mut self) -> Output {
        let child = self.0.take().expect("it is waited for once");
        child.wait_with_output().unwrap()
    }
}

impl Deref for Running {
    type Target = Child;

    fn deref(&self) -> &Child {
        self.0.as_ref().expect("it is there until waited for")
    }
}

impl DerefMut for Running {
    fn deref_mut(&mut self) -> &mut Child {
        self.0.as_mut().expect("it is there until waited for")
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            // The child may have ended by itself.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
