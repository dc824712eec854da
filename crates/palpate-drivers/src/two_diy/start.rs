//! Opening and setup of the device in a known pose.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use palpate_device::clock::Clock;
use palpate_device::{Capabilities, DeviceError};
use rustix::io::Errno;

use super::board::{Board, LARGEST_TORQUE};
use super::driver::{Ready, TwoDiy};
use super::kinematics::NoPose;
use super::layout::{Generation, Layout};
use super::line::{Line, Unsent};
use super::packet::{Heard, RECOVERY, RESET, Replies, setup};
use crate::serial::Serial;

/// Time limit for the port to accept bytes while the device is opened.
const LIMIT: Duration = Duration::from_millis(500);
/// Time limit for the first answer: a board that was just plugged in is busy.
const FIRST_ANSWER: Duration = Duration::from_millis(1000);
/// Polling interval for the first answer.
const LOOKS: Duration = Duration::from_millis(10);
/// Time without input after which the line is quiet.
const QUIET: Duration = Duration::from_millis(20);
/// Number of setup attempts, and the pause between them.
const ATTEMPTS: u32 = 3;
const COMES_TO_REST: Duration = Duration::from_millis(300);
/// Time after which a board stops waiting for the missing bytes of a packet.
const GIVES_UP: Duration = Duration::from_millis(1100);

/// Pose of the arm while the device is opened; the encoders count from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Calibration {
    /// Fully retracted, as Haply's examples require.
    Retracted,
    /// Fully extended; known for the third generation only.
    Extended,
    /// These angles of joints 1 and 2 `[degrees]`.
    At([f32; 2]),
}

/// Options for opening a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Wiring and links.
    pub layout: Layout,
    /// The board; `None`: derived from the first answer, if that determines it.
    pub board: Option<Board>,
    /// Board to assume if the first answer does not determine it.
    pub usual_board: Board,
    /// Time that a [`read`](palpate_device::Device::read) waits for the board. Half a period leaves time for the rest
    /// of a tick.
    pub patience: Duration,
    /// Name in reports.
    pub name: &'static str,
}

impl Options {
    /// Creates options for a generation as sold by Haply, with the arm in a known pose, for a loop of `period`.
    ///
    /// # Errors
    /// The pose is not published for this generation, or is invalid.
    pub fn new(
        generation: Generation,
        calibration: Calibration,
        period: Duration,
    ) -> Result<Self, OpenError> {
        let layout = generation.layout();
        let layout = match calibration {
            Calibration::Retracted => layout,
            Calibration::Extended => {
                layout.starting_at(generation.extended().ok_or(OpenError::NotPublished)?)
            }
            Calibration::At(angles) => layout.starting_at(angles),
        };
        layout.start_pose().map_err(OpenError::StartPose)?;
        Ok(Self {
            layout,
            board: None,
            usual_board: generation.usual_board(),
            patience: (period / 2).min(Duration::from_millis(20)),
            name: match generation {
                Generation::One => "Haply 2DIY, generation 1",
                Generation::Two => "Haply 2DIY, generation 2",
                Generation::Three => "Haply 2DIY, generation 3",
            },
        })
    }
}

/// Reason why a device could not be opened. No torque was commanded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The file does not exist.
    #[error("{0}: no such port; `palpate devices` lists the ports")]
    NotThere(PathBuf),
    /// Permission denied.
    #[error(
        "{0}: no permission; on Linux, join the group that owns the port (often `dialout`) and log \
         in again"
    )]
    NotAllowed(PathBuf),
    /// Another program has opened the port.
    #[error("{0}: another program has opened this port")]
    InUse(PathBuf),
    /// The file is not a serial port.
    #[error("{0}: not a serial port")]
    NotSerial(PathBuf),
    /// Another error of the operating system.
    #[error("{0}: {1}")]
    System(PathBuf, std::io::Error),
    /// The port disappeared during opening.
    #[error("the port disappeared while the device was being opened")]
    Gone,
    /// The port accepts no bytes.
    #[error("the port accepts no bytes: the board has stalled; unplug it and plug it in again")]
    TakesNothing,
    /// There was no answer.
    #[error("no answer from device {0}: not a Haply board, or one with other firmware")]
    NoAnswer(u8),
    /// Bytes arrived, but not an answer.
    #[error(
        "invalid answer from device {asked}: it begins with {first}; another generation, or not a Haply board"
    )]
    WrongAnswer {
        /// Requested device id.
        asked: u8,
        /// First received byte.
        first: u8,
    },
    /// The first byte was right, but too few or too many bytes followed.
    #[error(
        "device {0} sent no complete answer within a second: bytes are late or lost; try again on a less busy \
         machine or with another cable"
    )]
    BrokenAnswer(u8),
    /// The first angles are those of another board.
    #[error(
        "the first angles, {} degrees, are those of the board `{found}`, not of `{messages}`",
        pair(.angles), found = .found.name(), messages = .messages.name()
    )]
    OtherBoard {
        /// Received angles `[degrees]`.
        angles: [f32; 2],
        /// Board that matches these angles.
        found: Board,
        /// Board given in the options.
        messages: Board,
    },
    /// The first angles do not match the start pose.
    #[error(
        "the first angles, {} degrees, are not those of the start pose, {}: hold the arm still while the device is \
         opened, or correct the counts per revolution",
        pair(.angles), pair(.start)
    )]
    NotInPose {
        /// Received angles `[degrees]`.
        angles: [f32; 2],
        /// Expected angles `[degrees]`.
        start: [f32; 2],
    },
    /// The start pose is invalid.
    #[error("invalid start pose: {0}")]
    StartPose(NoPose),
    /// The angles of the extended pose are not published for this generation.
    #[error("the angles of the extended arm are known for generation 3 only; give them in degrees")]
    NotPublished,
}

impl<C: Clock> TwoDiy<C> {
    /// Opens the device on the port at `path`. **The arm must be in the start pose** and must be held still. The
    /// encoders count from that pose; opening in another pose gives forces in wrong directions. The driver checks only
    /// that the first angles equal the start pose as rounded by the board, which distinguishes boards and counts per
    /// revolution. It cannot measure the true pose.
    ///
    /// Removes a torque that the board may still hold first.
    ///
    /// # Errors
    /// The port cannot be opened, or the device on it is not a 2DIY.
    pub fn open(path: &Path, options: &Options, clock: C) -> Result<Self, OpenError> {
        let serial = Serial::open(path).map_err(|error| refused(path, error))?;
        let line = Line::new(serial, options.layout)
            .map_err(|error| OpenError::System(path.to_owned(), error))?;
        let mut failure = OpenError::NoAnswer(options.layout.device_id);
        for attempt in 0..ATTEMPTS {
            let answered = first_angles(&line, options)
                .and_then(|angles| Ok((angles, board(options, angles)?)));
            failure = match answered {
                Ok((angles, board)) => {
                    return Ok(Self::new(Ready {
                        clock,
                        line,
                        layout: options.layout,
                        board,
                        patience: options.patience,
                        capabilities: capabilities(options, board),
                        angles,
                    }));
                }
                // The arm may still be moving, because a torque was just removed.
                Err(moved @ OpenError::NotInPose { .. }) if attempt + 1 < ATTEMPTS => {
                    std::thread::sleep(COMES_TO_REST);
                    moved
                }
                // An earlier program may have left the board in the middle of a packet.
                Err(silent @ (OpenError::NoAnswer(_) | OpenError::WrongAnswer { .. }))
                    if attempt == 0 =>
                {
                    recover(&line)?;
                    silent
                }
                // The board is right; a busy machine delivered its bytes late.
                Err(broken @ OpenError::BrokenAnswer(_)) if attempt + 1 < ATTEMPTS => {
                    recover(&line)?;
                    broken
                }
                // The error of the first attempt is more informative.
                Err(OpenError::NoAnswer(_)) => return Err(failure),
                Err(error) => return Err(error),
            };
        }
        Err(failure)
    }
}

fn refused(path: &Path, error: Errno) -> OpenError {
    let path = path.to_owned();
    match error {
        Errno::NOENT | Errno::NODEV | Errno::NXIO | Errno::CONNREFUSED => OpenError::NotThere(path),
        Errno::ACCESS | Errno::PERM => OpenError::NotAllowed(path),
        Errno::BUSY => OpenError::InUse(path),
        Errno::NOTTY | Errno::INVAL | Errno::ISDIR => OpenError::NotSerial(path),
        other => OpenError::System(path, other.into()),
    }
}

impl From<Unsent> for OpenError {
    fn from(unsent: Unsent) -> Self {
        match unsent {
            Unsent::Gone => Self::Gone,
            Unsent::Busy | Unsent::Full | Unsent::Unguarded(_) => Self::TakesNothing,
        }
    }
}

/// Commands zero torque and sends the layout, whatever state the board is in. Afterwards the board holds zero torque
/// and the encoders count from the start pose. Takes more than a second.
pub(super) fn begin_anew(line: &Line, layout: &Layout) -> Result<(), DeviceError> {
    recover(line)
        .and_then(|()| set_up(line, layout))
        .map_err(DeviceError::from)
}

/// Completes any packet that the board is in the middle of.
fn recover(line: &Line) -> Result<(), Unsent> {
    line.command_patiently([0.0; 2], LIMIT)?;
    line.send(&RECOVERY, LIMIT)?;
    // The number of zeros may be odd for the board: its last RESET may still wait for an id, which must not be the
    // first byte of the next packet.
    std::thread::sleep(GIVES_UP);
    Ok(())
}

fn set_up(line: &Line, layout: &Layout) -> Result<(), Unsent> {
    // Before RESET: afterwards the board knows no motor whose torque it could remove. A board without a layout reads
    // these bytes as unknown bytes and four RESETs.
    line.command_patiently([0.0; 2], LIMIT)?;
    line.send(&RESET, LIMIT)?;
    line.send(&setup(layout), LIMIT)?;
    line.command_patiently([0.0; 2], LIMIT)
}

fn first_angles(line: &Line, options: &Options) -> Result<[f32; 2], OpenError> {
    set_up(line, &options.layout)?;
    // Discard the answers to the setup.
    until_quiet(line)?;
    line.command_patiently([0.0; 2], LIMIT)?;
    let mut replies = Replies::new(options.layout);
    let (mut first, mut answer) = (None, None);
    let begun = Instant::now();
    while begun.elapsed() < FIRST_ANSWER {
        let limit = if answer.is_some() { QUIET } else { LOOKS };
        line.serial().wait_readable(limit);
        let mut bytes = [0; 64];
        let read = line
            .serial()
            .read(&mut bytes)
            .map_err(|_| OpenError::Gone)?;
        if let (0, Some(angles)) = (read, answer) {
            return Ok(angles);
        }
        for byte in bytes.iter().take(read) {
            first.get_or_insert(*byte);
            answer = match replies.hear(*byte) {
                Heard::Angles(angles) => Some(angles),
                // The candidate was not an answer, or not the last one: one request has one answer.
                Heard::Part | Heard::Stray => None,
            };
        }
    }
    let asked = options.layout.device_id;
    Err(match first {
        None => OpenError::NoAnswer(asked),
        Some(first) if first == asked => OpenError::BrokenAnswer(asked),
        Some(first) => OpenError::WrongAnswer { asked, first },
    })
}

/// Discards input until the line is quiet. A busy system may deliver old bytes late, and the tail of an answer can look
/// like the beginning of another one.
fn until_quiet(line: &Line) -> Result<(), OpenError> {
    let begun = Instant::now();
    let mut bytes = [0; 64];
    while begun.elapsed() < FIRST_ANSWER {
        line.serial().wait_readable(QUIET);
        let read = line.serial().read(&mut bytes);
        if read.map_err(|_| OpenError::Gone)? == 0 {
            break;
        }
    }
    Ok(())
}

/// Determines the board from its rounding of the start pose.
fn board(options: &Options, angles: [f32; 2]) -> Result<Board, OpenError> {
    let joints = &options.layout.joints;
    let is_within = |board: Board, quanta: f64| {
        joints
            .iter()
            .enumerate()
            .zip(angles)
            .all(|((joint, messages), angle)| {
                let first = board.first_angle(messages.start, messages.counts_per_rev);
                (f64::from(angle) - first).abs() <= quanta * board.quantum(&options.layout, joint)
            })
    };
    // Tolerance for `f32` rounding, well below one count.
    let is_exact = |board: &Board| is_within(*board, 0.05);
    let exact = Board::ALL.into_iter().find(is_exact);
    let messages = options.board.unwrap_or(options.usual_board);
    if is_exact(&messages) {
        return Ok(messages);
    }
    match (exact, options.board) {
        (Some(found), None) => Ok(found),
        (Some(found), Some(messages)) => Err(OpenError::OtherBoard {
            angles,
            found,
            messages,
        }),
        // A hand moved the arm by one or two counts.
        (None, _) if is_within(messages, 3.0) => Ok(messages),
        (None, _) => Err(OpenError::NotInPose {
            angles,
            start: joints.map(|joint| joint.start),
        }),
    }
}

fn capabilities(options: &Options, board: Board) -> Capabilities {
    let geometry = options.layout.geometry;
    let reach = geometry.proximal + geometry.distal;
    let middle = 0.5 * geometry.base;
    let quantum = board.coarsest_quantum(&options.layout);
    // Evaluate along the centre line, away from singular poses.
    let (mut largest_force, mut encoder_quantum) = (f64::INFINITY, 0.0_f64);
    for step in 0..=100 {
        let opening = f64::from(step) / 100.0 * std::f64::consts::FRAC_PI_2;
        let angles = [
            std::f64::consts::FRAC_PI_2 + opening,
            std::f64::consts::FRAC_PI_2 - opening,
        ];
        let Ok(pose) = geometry.pose(angles) else {
            continue;
        };
        if pose.fading() < 1.0 {
            continue;
        }
        for axis in [0, 1] {
            let mut direction = [0.0; 2];
            direction[axis] = 1.0;
            largest_force = largest_force.min(pose.largest_force(direction, LARGEST_TORQUE.into()));
            let steps = pose.columns.map(|column| column[axis].abs() * quantum);
            encoder_quantum = encoder_quantum.max(steps[0]).max(steps[1]);
        }
    }
    Capabilities {
        largest_force: Some(largest_force).filter(|force| force.is_finite()),
        workspace: Some([
            [middle - reach, -0.5 * geometry.distal, 0.0],
            [middle + reach, reach, 0.0],
        ]),
        encoder_quantum: Some(encoder_quantum),
        holds_last_force: true,
        ..Capabilities::unknown(&format!("{}, board {}", options.name, board.name()), 2)
    }
}

/// Two angles as a person writes them.
fn pair([first, second]: &[f32; 2]) -> String {
    format!("{first:.2} and {second:.2}")
}
