//! The processes of the machine: users of a port, and children of a process.

use std::path::Path;

/// Whether a program other than this one, which is the board, has the port open.
pub fn is_held(port: &Path) -> bool {
    // The board's end of a connection has the socket's path, and the board closes it when all copies of
    // the other end are closed. 03 is the state "connected".
    let sockets = std::fs::read_to_string("/proc/net/unix").unwrap();
    let connected = sockets.lines().any(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        words.get(5) == Some(&"03") && words.get(7).map(Path::new) == Some(port)
    });
    connected
        || processes()
            .filter(|id| *id != std::process::id())
            .any(|id| {
                let Ok(descriptors) = std::fs::read_dir(format!("/proc/{id}/fd")) else {
                    return false;
                };
                descriptors
                    .filter_map(|entry| std::fs::read_link(entry.ok()?.path()).ok())
                    .any(|to| to == port)
            })
}

pub fn processes() -> impl Iterator<Item = u32> {
    std::fs::read_dir("/proc")
        .unwrap()
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok())
}

/// Returns the running programs that a program started.
pub fn children(parent: u32) -> Vec<u32> {
    processes()
        .filter(|id| {
            let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
            let Some((_, rest)) = stat.rsplit_once(") ") else {
                return false;
            };
            let mut rest = rest.split(' ');
            rest.next() != Some("Z") && rest.next() == Some(parent.to_string().as_str())
        })
        .collect()
}
