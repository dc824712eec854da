//! The command line: every command with its help. All commands share the flags of contact, method and device.

use clap::builder::styling::{AnsiColor, Styles};
use clap::{Parser, Subcommand};

use crate::arguments::{
    CompareArguments, CompletionArguments, DemoArguments, RenderArguments, SimulateArguments,
    SuiteArguments, SweepArguments, TuneArguments,
};
use crate::commands::advise::AdviseArguments;
use crate::commands::calibrate::CalibrateArguments;
use crate::commands::convert::ConvertArguments;
use crate::commands::devices::DevicesArguments;
use crate::commands::doctor::DoctorArguments;
use crate::commands::info::InfoArguments;
use crate::commands::live::LiveArguments;
use crate::commands::map::MapArguments;
use crate::commands::paper::PaperArguments;
use crate::commands::pipe::PipeArguments;
use crate::commands::replay::ReplayArguments;
use crate::commands::report::ReportArguments;
use crate::commands::run::RunArguments;

const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

/// Energy-consistent haptic contact rendering at any loop rate
#[derive(Parser, Debug)]
#[command(name = "palpate", version, styles = STYLES, max_term_width = 100)]
#[command(after_help = "\
palpate help <COMMAND> describes a command.
palpate completions <SHELL> prints shell completions.
palpate --version prints the version.

Examples:
  palpate demo          the main results in a few seconds
  palpate simulate experiments/fig2.toml --method all

Exit codes:
  0  done                              4  done, but the recording is incomplete
  1  a file was not read or written    5  the force was off at the end or mostly
  2  the arguments are wrong           6  the device or hand prevents a result
  3  an input file is wrong          130  a signal such as ctrl-C ended it early")]
pub struct Arguments {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Render a recorded motion
    #[command(override_usage = "\
palpate render <TRACE.csv> --stiffness <N/m> --mass <kg|inf> --period <s> [OPTIONS]
       palpate render <WORLD.toml> --input <RECORDING.csv> [OPTIONS]")]
    #[command(long_about = "\
Render a recorded motion.

Motion replay, the default: the recording prescribes the motion of the device; forces do not change it. Each \
sample gets the force that the method would hold, and the energy ledger reports the energy that this force \
would leak on this motion. The ideal is the same object in continuous time, on the recording at its full rate \
with linear interpolation between samples. If the loop's period is a multiple of the recording's, samples are \
used exactly; otherwise they are interpolated linearly. The column virtual_force_n of the trace is a force on the \
object from each sample to the next, in addition to --force.

Hand replay, --replay hand: the force of the hand on a device of --device-mass is estimated from the motion, \
and the loop is closed again: the device moves under that hand and the new force. The column force_on_device_n \
of the trace is the motor force during the recording, held from each sample to the next; without the column it \
is 0. The report gives the accuracy of the estimate. The recording does not determine the hand's reaction to \
another motion: a spring of --hand-stiffness and --hand-damping connects the hand to its recorded motion. With \
0 for both, its force stays the recorded one, and any other force moves the device away without limit. A \
replay in which even the ideal force moves the device 1 m away is rejected. Times count from the first sample.

In a world, --input is the motion of its devices in the columns t,x,y,z (x,y,z again for each further device), \
in seconds and metres along the world's axes. Only motion replay is available. --out writes the force that \
each method commands at each sample.")]
    #[command(after_help = "\
Examples:
  palpate render tap.csv --stiffness 400 --mass 0.1 --period 0.01 --force -0.981 --out run.csv
  palpate render tap.csv --stiffness 400 --mass inf --period 0.001 --method all --plot tap.svg
  palpate render tap.csv --stiffness 400 --mass 0.1 --period 0.01 --replay hand --device-mass 0.2
  record | palpate render - --stiffness 400 --mass 0.1 --period 0.01 --json
  palpate render experiments/worlds/paddle.toml --input motion.csv --method basic,coupled")]
    Render(RenderArguments),
    /// Simulate a scene in closed loop, and compare it with its ideal
    #[command(long_about = "\
Simulate a scene in closed loop, and compare it with its ideal.

The device moves between samples under the held force. The ideal is the same scene in continuous time. For a \
point mass under a constant force it is computed event by event in closed form. With friction, a hand model or \
a linkage it is integrated in fine steps, and the report gives its accuracy. Flags override values of the \
scene.")]
    #[command(after_help = "\
Examples:
  palpate simulate experiments/fig2.toml --method all --plot fig2.svg
  palpate simulate experiments/experiment2.toml --method virtual-damper --damping 4
  palpate simulate experiments/wall.toml --stiffness 5000 --delay-periods 1 --json
  palpate simulate experiments/fig2.toml --method all --jitter 0.002 --drop 0.05 --seeds 20")]
    Simulate(SimulateArguments),
    /// Compare methods on many scenes, in one table
    #[command(override_usage = "palpate compare <SCENE.toml>... [OPTIONS]")]
    #[command(long_about = "\
Compare methods on many scenes, in one table.

Every method runs on every scene in closed loop, with the scene's settings for it or its defaults. E is the \
avoidable part of the force error. FRE/bound is the whole force error over the hold bound, the smallest error \
of any held force in that loop. peak/ideal is the largest force over that of the ideal. If a method cannot be \
set up on a scene, its row gives the reason.

Worlds are compared with worlds. If the scene has no setting for virtual-damper, virtual-coupling or \
god-object, the candidates of tune are tried, and the setting with the smallest E is used.")]
    #[command(after_help = "\
Examples:
  palpate compare experiments/fig2.toml experiments/experiment1.toml
  palpate compare experiments/fig2.toml --method basic,virtual-damper,hfcr --json
  palpate compare experiments/users/*.toml --out table.csv
  palpate compare experiments/worlds/paddle.toml experiments/worlds/pushed-block.toml")]
    Compare(CompareArguments),
    /// Render live: positions in, forces on the device out, line by line
    #[command(override_usage = "\
palpate pipe --stiffness <N/m> --mass <kg|inf> --period <s> --device-mass <kg> [OPTIONS]
       palpate pipe --scene <SCENE.toml> [OPTIONS]")]
    #[command(long_about = "\
Render live: positions in, forces on the device out, line by line.

Each line of standard input is a position in metres, or with --time a time and a position, `t_s,position_m`; \
with --unit mm positions are in millimetres. Each is answered by one line on standard output, flushed at once: \
the force ON THE DEVICE in newtons. Command it to the motor unchanged and hold it until the next line. \
--columns adds further values.

           device           object
  ----------->|      |=========|     + axis, --side positive
     <--------|
  force on the device: negative while the object pushes back

The default method, coupled, predicts the device together with the object, so it needs the approximate mass of \
your device at the grip: --device-mass within a factor of 2, or the device of a --scene. The other methods \
need no mass.

THE LAST LINE ANSWERS NO LINE: when the input ends, or SIGINT or SIGTERM ends the pipe (exit code 130), one \
more line sets the force to 0, if there was a line before. Its column phase is `ended`. Therefore the output \
has one line more than there are samples.

Forces are limited to 20 N (to the motor_limit_n of a --scene if that is less). In contact at the start or \
after a recovery, the force ramps up over 0.2 s. Both are as in `run`; --force-limit inf and --soft-start 0 \
disable them.

With --time, the measured period is used; without it, lines are one --period apart. A header `position_m` or \
`t_s,position_m` in the first line gets no answer and overrides --time; with virtual_force_n after it, each \
sample has a force on the object, added to --force. A line that is not a sample is \
answered by 0 and a message on standard error, and the pipe continues; if every line is one of these, the exit \
code is 5. A line whose time does not increase is treated in the same way, and time continues from there. A \
wrong number of columns or an implausible motion ends the pipe with exit code 3: a decimal comma or another \
unit must not move a motor.

A line `set stiffness_n_per_m=800 mass_kg=0.2 virtual_force_n=-1`, with any of these or damping_n_s_per_m, \
changes them while the pipe runs, over 0.1 s. It gets no line on standard output. Standard error confirms the change, or gives \
the reason why nothing changes.

--delay is the time from a line to the beginning of its force, --lag and --gain describe the \
actuator; each line is answered at once by the command for the actuator. When the input ends, a summary of the \
energy ledger goes to standard error.")]
    #[command(after_help = "\
Examples:
  my-device | palpate pipe --stiffness 400 --mass 0.1 --period 0.001 --device-mass 0.2
  my-device | palpate pipe --scene experiments/experiment1.toml --columns force,object_position
  printf '0\\n0.001\\n' | palpate pipe --stiffness 1000 --mass inf --period 0.001 --method hfcr")]
    Pipe(PipeArguments),
    /// Measure mass, delay, lag and friction of a device in its loop
    #[command(override_usage = "\
palpate calibrate --device <NAME> [OPTIONS]
       palpate calibrate --pipe --period <s> [OPTIONS]")]
    #[command(long_about = "\
Measure mass, delay, lag and friction of a device in its loop.

Hold the device as in use. A force of at most --largest-force pushes it to and fro in steps of 5 to 15 ms, \
within --box of its start position. The first 0.5 s are without force, the force ramps up and down over 0.3 s, \
and the last force is 0. A fit of the motion then estimates the effective mass, the delay from a sample to its \
force, the lag of the motor, friction, hand, first resonance and sensor, each with its standard deviation. \
--out writes them as a device file.

With --pipe, each line of standard input is a position in metres, or with --time a time and a position. Each \
is answered by one line on standard output, flushed at once: the force ON THE DEVICE in newtons. Command it to \
the motor unchanged and hold it until the next line. After --seconds of samples the command ends; the answer \
to the last sample is 0. If the input, a signal or the device ends it earlier, one more line sets the force to \
0.

The command fails with exit code 6 and writes nothing if the device leaves the box, the hand moves too much, \
friction is close to the force, or the motion does not determine the values.")]
    #[command(after_help = "\
Examples:
  my-device | palpate calibrate --pipe --period 0.001 --out device.toml
  palpate calibrate --device haply-2diy --normal 1,0 --out device-x.toml --plot device-x.svg")]
    Calibrate(CalibrateArguments),
    /// Run a loop in real time on a device, and record it on request
    #[command(override_usage = "palpate run <SCENE.toml> [OPTIONS]")]
    #[command(long_about = "\
Run a loop in real time on a device, and record it on request.

A separate thread wakes at absolute deadlines, reads the device, renders, and commands the force within the \
safety limits. It requests real-time priority, and a warning reports a refusal. Ctrl-C ends it. At every end \
the commanded force is 0; a supervisor commands it if the thread does not respond. For a device that holds its \
last force, a watchdog process does so if this process is killed or stopped. Missed deadlines are counted and \
skipped, and the renderer uses the elapsed time. Flags override values of the scene. A world (format = 2) is \
rendered on devices with up to three axes; docs/worlds.md describes their frames.

The exit code is 5 if the loop ran without force at its end or for most of its time, because safety disabled \
the motors or the renderer rejected the samples.

--record writes every tick to a recording. The loop never waits for the disk. Ticks that could not be written \
are missing from the numbering and reported at the end, with exit code 4. Written data survive every end of \
the program. During recording the file is called NAME.part.")]
    #[command(after_help = "\
Examples:
  palpate run experiments/experiment1.toml --device simulated --duration 3
  palpate run experiments/wall.toml --method hfcr --fast --json
  palpate run experiments/wall.toml --record wall.mcap --fast --duration 60
  palpate run experiments/fig2.toml --duration 2 --record fig2.mcap --safe-force 5
  palpate run experiments/worlds-on-devices/ball-on-table.toml --duration 2")]
    Run(RunArguments),
    /// Run a loop and serve a live page on it
    #[command(override_usage = "palpate live [SCENE.toml] [OPTIONS]")]
    #[command(mut_arg("device", |device| device.default_value("pointer")))]
    #[command(long_about = "\
Run a loop and serve a live page on it.

The page shows device, object, force and energy, moves the hand with the mouse, changes stiffness, mass, \
weight, rate and method while the loop runs, and records. Two methods run in two loops side by side, in the \
same hand. The default scene is a light block that rests on the device at 100 Hz, rendered by the plain spring \
force and by coupled rendering. A world (format = 2) is shown in three dimensions.

Only pages of this server, opened on this machine, have access. With --listen on another address, anyone with \
the printed token can watch and move the device. Ctrl-C ends it; at every end the commanded force is 0. See \
docs/live-view.md.")]
    #[command(after_help = "\
Examples:
  palpate live
  palpate live experiments/experiment1.toml --method basic,hfcr
  palpate live --method coupled --record held.mcap --duration 0.5
  palpate live experiments/experiment1_in_a_hand.toml --device simulated
  palpate live experiments/worlds/pushed-block.toml --method basic,coupled")]
    Live(LiveArguments),
    /// List the available devices, check the wiring of one, or emulate one
    #[command(args_conflicts_with_subcommands = true)]
    #[command(override_usage = "\
palpate devices [OPTIONS]
       palpate devices check haply-2diy --move [OPTIONS]
       palpate devices emulate <haply-2diy|inverse3> [OPTIONS]")]
    #[command(long_about = "\
List the available devices with the flags that open them, check the wiring of one, or emulate one. Serial \
ports are listed with their USB descriptions, the most likely first. Nothing is sent to them.")]
    #[command(after_help = "\
Examples:
  palpate devices
  palpate devices --json
  palpate devices emulate haply-2diy --hold 0.019,0.05 --duration 1")]
    Devices(DevicesArguments),
    /// Disable the output of a device if its loop cannot; started by the commands that run a loop
    #[command(hide = true)]
    Watchdog,
    /// Report the real-time properties of this machine, and try a loop
    #[command(long_about = "\
Report the real-time properties of this machine, and try a loop.

After each request, the granted value is read back from the kernel. A refused request is listed with its \
remedy. The results do not imply a hard bound.

With --bench, only the timing of the loop is measured, at each --rate for --duration seconds.")]
    #[command(after_help = "\
Examples:
  palpate doctor
  palpate doctor --priority 0 --json
  palpate doctor --bench --duration 1
  palpate doctor --bench --rate 500,4000 --duration 1 --spin 0.0001 --json")]
    Doctor(DoctorArguments),
    /// Describe the contents of a recording, and its gaps
    #[command(long_about = "\
Describe the contents of a recording, and its gaps.

A recording is an MCAP file written by a loop with a device. A truncated recording, or one that is being \
written (NAME.part), is read as far as possible. Lost ticks are counted from the tick numbers and from the \
loop's own counters. Chunks with a wrong checksum are rejected. Chunks in lz4 and zstd, as written by other \
tools, are supported.")]
    #[command(after_help = "\
Examples:
  palpate info tap.mcap
  palpate info tap.mcap --text scene > scene.toml
  palpate info tap.mcap --json")]
    Info(InfoArguments),
    /// Write a recording as a table
    #[command(long_about = "\
Write a recording as a table: one line per tick; events go to a separate table, one line each.

Gaps of the recording are reported on standard error, in the table's metadata, and by exit code 4; the table \
is written nevertheless.")]
    #[command(after_help = "\
Examples:
  palpate convert tap.mcap
  palpate convert tap.mcap --to csv --out table.csv")]
    Convert(ConvertArguments),
    /// Render a recording by another method, as a motion or as a hand
    #[command(override_usage = "palpate replay <REC.mcap> --method <NAMES> [OPTIONS]")]
    #[command(long_about = "\
Render a recording by another method.

Contact, loop, settings and device are those of the scene in the recording's metadata; flags override them. \
The object starts in its state at the first tick. The recorded loop is drawn beside the methods.

Motion replay, the default: the device follows the recorded motion at the recorded times, regardless of the \
force. This shows the force law on real motion and the energy that it would have leaked, but not the reaction \
of the hand.

Hand replay, --replay hand: the force of the hand is estimated from the motion and from the sent force, and \
the loop is closed again: the device moves under that hand and the new force, sampled at the recorded times. \
The device has the mass of the scene's, or --device-mass. Lost ticks and ticks without a position are bridged \
with lower accuracy; a gap longer than --largest-gap is rejected. The report gives the accuracy of the \
estimate. The recording does not determine the hand's reaction to another motion: a spring of --hand-stiffness \
and --hand-damping connects the hand to its recorded motion. With 0 for both, its force stays the recorded \
one. A replay in which even the ideal force moves the device 1 m away is rejected. Times count from the first \
position.")]
    #[command(after_help = "\
Examples:
  palpate replay tap.mcap --method hfcr
  palpate replay tap.mcap --method basic,coupled --plot replay.svg --out replay.csv
  palpate replay tap.mcap --method all --json
  palpate replay tap.mcap --replay hand --method basic,coupled --plot hand.svg
  palpate replay tap.mcap --replay hand --device-mass 0.3 --hand-stiffness 200 --hand-damping 5")]
    Replay(ReplayArguments),
    /// Write a page about a device: its timing, calibration and contacts
    #[command(override_usage = "\
palpate report [RECORDING.mcap]... [--device-file <FILE.toml>] --out <PAGE.html> [OPTIONS]
       palpate report --device <NAME> [--device-file <FILE.toml>] --out <PAGE.html> [OPTIONS]")]
    #[command(long_about = "\
Write a page about a device: its timing, calibration, renderable contacts, a contact, warnings.

The page is one HTML file without scripts or network access, readable on a phone and printable on two sheets \
of A4. Its contents come from recordings, from a calibrated device file, or from a simulation with their \
values, and the page names the source of each. Each warning has a remedy.

With --device, a short session is recorded first, as `palpate run --record` does, with the same safety, \
supervisor and watchdog; 5 s unless --duration is given. Move the device into the wall at 0, or into the \
object of the --scene, to feel the force. The recording stays beside the page.

Renderable contacts are a coarse map with the mass, period, delay, lag, gain, friction and sensor of this \
device. On a terminal a bar shows the current part, the completed steps and the time; otherwise lines on \
standard error do, after 30 s and whenever the time has doubled. The page gives the resolution and the \
computing time.")]
    #[command(after_help = "\
Examples:
  palpate report tap.mcap --out device.html
  palpate report tap.mcap --device-file device.toml --calibration fit.json --out device.html
  palpate report --device-file device.toml --name 'Arm no. 7' --json
  palpate report --device simulated --scene wall.toml --duration 2 --out device.html")]
    Report(Box<ReportArguments>),
    /// Find the best damping of a method for a scene
    #[command(long_about = "\
Find the best damping of a method for a scene, and draw the whole curve.

The varied setting is B of virtual-damper, b of hfcr, the cap of popc and popc-ref, the assumed damping of \
force-bounding, or the damping of energy-tank and virtual-coupling. Each value is simulated \
from 21 start heights around the scene's (the gap changes by up to 5 %), because the best value at one height \
can be bad at the next; the best value has the smallest median. --from and --to set the range; the flag of the \
varied damping is rejected.

On a world, the varied setting is the damping of virtual-damper, virtual-coupling or god-object, for the \
latter two with each of several couplings, evaluated on the unchanged scene.")]
    #[command(after_help = "\
Examples:
  palpate tune experiments/fig2.toml --method virtual-damper --plot damper.svg
  palpate tune experiments/experiment2.toml --method hfcr --to 2 --least leak
  palpate tune experiments/experiment1.toml --method popc-ref --from 0.05 --to 15 --steps 300 --json
  palpate tune experiments/worlds/paddle.toml --method god-object --plot god-object.svg")]
    Tune(TuneArguments),
    /// Evaluate methods on random plants
    #[command(long_about = "\
Evaluate methods on random plants.

Device, hand, object, loop and sensor are drawn over the whole range of desktop devices; see docs/suite.md. \
Each plant is simulated over its first three collisions by every method with its default settings, without \
delay and with a modelled or unmodelled delay of one sample, and evaluated against the ideal of the same \
plant. The same seed gives the same plants in every version, and plant i does not depend on the number of \
plants. The results do not depend on the number of threads (RAYON_NUM_THREADS), to the last digit.

--columns defines variants of methods to compare: a TOML file with one table per column, named like the \
column, with `method` and the settings of [methods.NAME] in scenes. A damping can be a list, or \
`damping_over_k_t`, one number or a list. The best value of a list on each plant counts, which requires \
knowledge of the ideal. A column can have a `guard`.")]
    #[command(after_help = "\
Examples:
  palpate suite --plants 40 --seeds 7
  palpate suite --plants 20 --seed 7 --method hfcr,virtual-damper --plot suite.svg --out suite.csv
  palpate suite --plants 5 --method hfcr --write-scenes plants --json")]
    Suite(SuiteArguments),
    /// Vary one quantity of a scene, and show the effect on each method
    #[command(override_usage = "\
palpate sweep <SCENE.toml> --over <QUANTITY> --values <NUMBERS> [OPTIONS]")]
    #[command(long_about = "\
Vary one quantity of a scene, and show the effect on each method.

For each value, the scene runs in closed loop and is evaluated against the ideal of that value. The column \
`rebound` is the largest energy of a rebound, divided by the energy of the ideal's first rebound. Up to 1.1 \
the bounce is stable, up to 2 almost stable, above that unstable. `diverged` is as in `simulate`.")]
    #[command(after_help = "\
Examples:
  palpate sweep experiments/fig4.toml --over friction --values 1,10 --collisions 8 --method seh
  palpate sweep experiments/fig5.toml --over box --values 0.1,0.11,0.5 --method hfcr,coupled
  palpate sweep experiments/fig2.toml --over damping --values 0,0.03 --method hfcr --heights --json")]
    Sweep(SweepArguments),
    /// Map which stiffness and mass each method can render
    #[command(long_about = "\
Map which stiffness and mass each method can render.

Each cell is a separate scene: an object that bounces on the device, with kappa = K T²/m and Kc = K T²/M from \
0.001 to 10, from 16 start heights, by every method, on a device with and without friction. The map contains \
the growth of the bounce energy per collision, and the deviation of the force from the ideal's. Ctrl-C keeps \
completed cells; --resume continues. Parts can be computed separately, on any machine.")]
    #[command(after_help = "\
Examples:
  palpate map --cells 9
  palpate map --cells 9 --delay-periods 1 --method hfcr,basic --out delayed.csv --json
  palpate map --cells 9 --shard 1/3 --resume")]
    Map(MapArguments),
    /// Report whether a device can render a contact, and by which method
    #[command(override_usage = "\
palpate advise --device-mass <kg> --period <s> [OPTIONS]")]
    #[command(long_about = "\
Report whether a device can render a contact, and by which method.

The answer is a text followed by tables: the behaviour of each method with the desired stiffness and mass, the \
best damping, and the largest stiffness and smallest mass on this device. The scene is that of the map, an \
object that bounces on the device in a hand without damping, searched along stiffness and mass. Classical \
bounds of walls follow below.")]
    #[command(after_help = "\
Examples:
  palpate advise --device-mass 0.3 --period 0.002 --stiffness 2000 --mass 0.05
  palpate advise --device-mass 0.25 --period 0.02 --viscous-friction 0.5 --json")]
    Advise(AdviseArguments),
    /// Show figures, claims and start heights of the paper
    #[command(after_help = "\
Examples:
  palpate paper figure fig1
  palpate paper claims
  palpate paper heights experiments/experiment2.toml --method hfcr,hfcr-mod-st --json")]
    Paper(PaperArguments),
    /// Show the main results, without any input
    #[command(after_help = "\
Example:
  palpate demo --out-dir first-look")]
    Demo(DemoArguments),
    /// Print a completion script for a shell
    #[command(hide = true)]
    #[command(after_help = "\
Example:
  palpate completions bash > ~/.local/share/bash-completion/completions/palpate")]
    Completions(CompletionArguments),
}
