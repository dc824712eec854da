//! The command line: every command with its help. All commands share the flags of contact, method and device.

use clap::builder::styling::{AnsiColor, Styles};
use clap::{Parser, Subcommand};

use crate::arguments::{
    ClaimsArguments, CompareArguments, CompletionArguments, DemoArguments, FigureArguments,
    HeightsArguments, RenderArguments, SimulateArguments, SuiteArguments, SweepArguments,
    TuneArguments,
};
use crate::commands::advise::AdviseArguments;
use crate::commands::bench::BenchArguments;
use crate::commands::calibrate::CalibrateArguments;
use crate::commands::convert::ConvertArguments;
use crate::commands::devices::DevicesArguments;
use crate::commands::doctor::DoctorArguments;
use crate::commands::emulate::EmulateArguments;
use crate::commands::info::InfoArguments;
use crate::commands::live::LiveArguments;
use crate::commands::map::MapArguments;
use crate::commands::pipe::PipeArguments;
use crate::commands::replay::ReplayArguments;
use crate::commands::report::ReportArguments;
use crate::commands::run::{RecordArguments, RunArguments};

const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

/// Energy-consistent haptic contact rendering.
///
/// Renders the contact of a haptic device with a virtual object of finite mass, or a wall, at any loop rate, and
/// reports the energy that each method generates and its force error relative to the ideal force.
#[derive(Parser, Debug)]
#[command(name = "palpate", version, styles = STYLES, max_term_width = 100)]
#[command(after_help = "\
Examples:
  palpate demo                                      the whole story in a few seconds
  palpate simulate experiments/fig2.toml --method all
  palpate render hand.csv --stiffness 400 --mass 0.1 --period 0.01 --method all --plot hand.svg

Exit codes:
  0  done
  1  a file could not be read or written
  2  the arguments are wrong
  3  an input file is wrong; the message says where
  4  done, but the recording that was read or made is not whole; the output or
     standard error says what is missing
  5  the loop ran, but at its end or for most of its time safety had the motors off
     or the renderer refused the samples, or a pipe refused every line or was stopped by
     safety: there was no force
  6  nothing can be said of a device; the message says why
  130  stopped by ctrl-C or another signal before its end; what is done is kept")]
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

Motion replay, the default: the recording drives the virtual object; it cannot be pushed back. Each \
sample gets the force the method would have held, and the energy ledger says what that force would \
have leaked on this very motion. The ideal it is held against is the same object, driven in continuous \
time by the recording at its full rate, straight lines between its samples. Where the loop's period is \
a multiple of the recording's, samples are taken exactly; else they are interpolated on the same \
lines.

Hand replay, --replay hand: the force of the hand on a device of --device-mass is estimated from the \
motion, and the loop is closed again: the device moves under that hand and the new force. What force \
the motor held while the motion was recorded stands in the column force_on_device_n of the trace, from \
each sample until the next; without the column it is taken to have been off. The report says how well \
the hand is known. Nothing in a recording says what the hand would have done elsewhere. It is taken to \
hold on to its motion with --hand-stiffness and --hand-damping. With 0 for both, its force stays what \
it was, and a push that it did not have carries the device off for good. What carries even the ideal \
device 1 m away is refused. Times count from the first sample.

In a world, --input has the motion of its devices in the columns t,x,y,z (x,y,z again for each further \
device), in seconds and metres along the world's axes. Motion replay only. --out writes the force that \
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

The device moves between samples under the held force. The ideal is the same scene in continuous \
time: event by event in closed form for a point mass under a constant force, integrated in fine \
steps for one with friction or a hand of its own and for a linkage, and then the report says how \
exactly. Flags change values of the scene.")]
    #[command(after_help = "\
Examples:
  palpate simulate experiments/fig2.toml --method all --plot fig2.svg
  palpate simulate experiments/experiment2.toml --method virtual-damper --damping 4
  palpate simulate experiments/wall.toml --stiffness 5000 --delay 1 --json
  palpate simulate experiments/fig2.toml --method all --jitter 0.002 --drop 0.05 --seeds 20")]
    Simulate(SimulateArguments),
    /// Compare methods on many scenes, in one table
    #[command(override_usage = "palpate compare <SCENE.toml>... [OPTIONS]")]
    #[command(long_about = "\
Compare methods on many scenes, in one table.

Every method runs on every scene in closed loop, with the settings that the scene has for it or its \
defaults. E is the part of the force error that a method can avoid, FRE/floor the whole of it over \
the least that any force held in that loop can have, peak/ideal the strongest force over that of the \
ideal. A method that cannot be set up on a scene says why.

Worlds are compared with worlds. Where the scene has no setting for virtual-damper, virtual-coupling or \
god-object, the settings that tune tries are tried, and the one of the least E is taken.")]
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

Each line of standard input is a position in metres, or with --time a time and a position, \
`t_s,position_m`; --unit mm takes millimetres. Each is answered by one line on standard output, flushed \
at once: the force ON THE DEVICE in newtons, to be commanded to the motor as it is and held until the \
next line. --columns asks for more than the force.

           device           object
  ----------->|      |=========|     + axis, --side positive
     <--------|
  force on the device: negative while the object pushes back

The default method, coupled, predicts the device together with the object, so it has to know about how \
heavy your device is where you hold it: --device-mass within a factor of 2, or the device of a --scene. \
The other methods need no mass.

THE LAST LINE ANSWERS NO LINE: when the input ends, or SIGINT or SIGTERM ends the pipe (exit code 130), \
one more line takes the force off, if there was a line before. It has a force of 0, and `ended` in the \
column phase. So there is one line more than there were samples.

Forces are limited to 20 N (to the motor_limit_n of a --scene if that is less). Where a start or a \
recovery finds contact, the force comes in over 0.2 s. Both are as in `run`; --force-limit inf and \
--soft-start 0 switch them off.

With --time, the measured period is used; without, each line comes one --period after the last. A \
first line that is the header `position_m` or `t_s,position_m` gets no answer, and decides in place of \
--time. A line that is not a sample is answered by 0 and a message on standard error, and the pipe \
lives on; where every line was one of these it ends with exit code 5. So is a line whose time does not come after that of the line before; the clock goes on from \
there. Numbers of another count than was asked for, and a motion that no hand makes, end the pipe with \
exit code 3: a decimal comma or another unit must not move a motor.

A line `set stiffness_n_per_m=800 mass_kg=0.2 virtual_force_n=-1`, with any of the three, changes them \
while the pipe runs, over 0.1 s. It gets no line on standard output; standard error says that it is \
taken, or why not, and then nothing changes.

--delay says how many periods after its line a force really acts, --lag and --gain what the actuator makes of \
it; each line gets at once the command that the actuator is to get. When the input ends, a summary of the energy ledger goes to standard error.")]
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
within --box of where it starts. The first 0.5 s are without force, the force comes in and goes out over \
0.3 s, and the last force is 0. A fit of the motion then says the effective mass, the delay from a sample \
to its force, the lag of the motor, friction, hand, first resonance and sensor, each with its standard \
deviation. --out writes them as a device file.

With --pipe, each line of standard input is a position in metres, or with --time a time and a position. \
Each is answered by one line on standard output, flushed at once: the force ON THE DEVICE in newtons, to be \
commanded to the motor as it is and held until the next line. After --seconds of samples the command ends \
by itself; the answer to the last sample is 0. Where the input, a signal or the device ends it earlier, one \
more line takes the force off.

The command declines with exit code 6, and writes nothing, where the device leaves the box, the hand moves \
too much, friction is near to the force, or the motion says too little.")]
    #[command(after_help = "\
Examples:
  my-device | palpate calibrate --pipe --period 0.001 --out device.toml
  palpate calibrate --device haply-2diy --normal 1,0 --out device-x.toml --plot device-x.svg")]
    Calibrate(CalibrateArguments),
    /// Run a loop in real time, on a device
    #[command(override_usage = "palpate run <SCENE.toml> [OPTIONS]")]
    #[command(long_about = "\
Run a loop in real time, on a device.

A thread of its own wakes at absolute deadlines, reads the device, renders, and commands what safety \
lets through: it is the first to be served if the machine grants that, and says so if not. Ctrl-C \
ends it; whatever ends it, the device is commanded no force, and while the thread does not answer a \
supervisor does that. For a device that holds its last force a watchdog, a process of its own, does that \
if this one is killed or stopped. A deadline that is missed is counted and skipped, and the renderer is told the \
time that really passed. Flags change values of the scene. A world (format = 2) is rendered on one device \
with up to three axes; docs/worlds.md says where the device stands in it.")]
    #[command(after_help = "\
Examples:
  palpate run experiments/experiment1.toml --device simulated --duration 3
  palpate run experiments/wall.toml --method hfcr --fast --json
  palpate run experiments/fig2.toml --duration 2 --record fig2.mcap --safe-force 5
  palpate run experiments/worlds-on-devices/ball-on-table.toml --duration 2")]
    Run(RunArguments),
    /// Run a loop in real time and record every tick of it
    #[command(override_usage = "palpate record <SCENE.toml> <REC.mcap> [OPTIONS]")]
    #[command(long_about = "\
Run a loop in real time and record every tick of it.

As `run`, with a recording: the loop never waits for the disk, what could not be written is missing \
by its number and said in the end, and what was written survives whatever ends the program. While it \
is made it is called NAME.part.")]
    #[command(after_help = "\
Examples:
  palpate record experiments/experiment1.toml falls.mcap --duration 2
  palpate record experiments/wall.toml wall.mcap --fast --duration 60")]
    Record(RecordArguments),
    /// Run a loop and serve a live page on it
    #[command(override_usage = "palpate live [SCENE.toml] [OPTIONS]")]
    #[command(mut_arg("device", |device| device.default_value("pointer")))]
    #[command(long_about = "\
Run a loop and serve a live page on it.

The page shows device, object, force and energy as they are, leads the hand with the mouse, changes \
stiffness, mass, weight, rate and method while the loop runs, and records. Two methods are two loops \
side by side, in the same hand. Without a scene it is a light block that lies on the device by its \
weight at 100 Hz, by the plain spring force and by coupled rendering. A world (format = 2) is shown in three \
dimensions.

Only this machine can look, and no page of another server. With --listen on another address whoever \
has the printed token can look, and move the device. Ctrl-C ends it; whatever ends it, the device is \
commanded no force. docs/live-view.md has the rest.")]
    #[command(after_help = "\
Examples:
  palpate live
  palpate live experiments/experiment1.toml --method basic,hfcr
  palpate live --method coupled --record held.mcap --duration 0.5
  palpate live experiments/experiment1_in_a_hand.toml --device simulated
  palpate live experiments/worlds/pushed-block.toml --method basic,coupled")]
    Live(LiveArguments),
    /// List the available devices, or check the wiring of one
    #[command(override_usage = "\
palpate devices [OPTIONS]
       palpate devices check haply-2diy --move [OPTIONS]")]
    #[command(long_about = "\
List the devices that are here, with what opens them, or check the wiring of one. Serial ports come with what they say of themselves over USB, the likeliest first. Nothing is sent to \
any of them.")]
    #[command(after_help = "\
Examples:
  palpate devices
  palpate devices --json")]
    Devices(DevicesArguments),
    /// Emulate a device for trials without hardware
    #[command(override_usage = "\
palpate emulate haply-2diy [OPTIONS]
       palpate emulate inverse3 [OPTIONS]")]
    #[command(long_about = "\
Emulate a device, to try without one.

What is printed on standard output is where to open it: `palpate run SCENE.toml --device haply-2diy \
--port PATH`, or `--device inverse3 --service URL`. It moves in real time until ctrl-C.")]
    #[command(after_help = "\
Examples:
  palpate emulate haply-2diy --duration 1
  palpate emulate haply-2diy --hold 0.019,0.05 --sway 0,0.02 --link my-2diy --duration 1
  palpate emulate haply-2diy --generation 2 --board m3 --fault stall=0.1@0.5 --duration 1
  palpate emulate inverse3 --port 0 --events-port 0 --hold 0.01,0,0 --duration 1")]
    Emulate(EmulateArguments),
    /// Disable the output of a device if its loop cannot; started by the commands that run a loop
    #[command(hide = true)]
    Watchdog,
    /// Report the real-time properties of this machine, and try a loop
    #[command(long_about = "\
Ask what this machine grants a loop, and try one.

What is asked for is looked up afterwards where the kernel keeps it: granted is what is, not what a \
call returned. What is refused comes with what can be done about it. No hard bound follows from any \
of it.")]
    #[command(after_help = "\
Examples:
  palpate doctor
  palpate doctor --priority 0 --json")]
    Doctor(DoctorArguments),
    /// Measure the timing of the loop on this machine
    #[command(after_help = "\
Examples:
  palpate bench loop --duration 1
  palpate bench loop --rate 500,4000 --duration 1 --spin 0.0001 --json")]
    Bench(BenchArguments),
    /// Describe the contents of a recording, and its gaps
    #[command(long_about = "\
Say what is in a recording, and what is missing from it.

A recording is an MCAP file that a loop with a device has written; one that was cut off, or that is \
being written (NAME.part), is read as far as it goes. Lost ticks are counted from the numbers of \
those that are there and from what the loop itself has counted, and no chunk is believed whose checksum \
does not fit. Chunks in lz4 and zstd, as other tools write them, are read as well.")]
    #[command(after_help = "\
Examples:
  palpate info tap.mcap
  palpate info tap.mcap --text scene > scene.toml
  palpate info tap.mcap --json")]
    Info(InfoArguments),
    /// Write a recording as a table
    #[command(long_about = "\
Write a recording as a table: one line per tick, and one per event in a table of their own.

What is missing from the recording is said on standard error, in the table's metadata, and by exit \
code 4; the table is written all the same.")]
    #[command(after_help = "\
Examples:
  palpate convert tap.mcap
  palpate convert tap.mcap --to csv --out table.csv")]
    Convert(ConvertArguments),
    /// Render a recording by another method: its motion, or its hand in closed loop
    #[command(override_usage = "palpate replay <REC.mcap> --method <NAMES> [OPTIONS]")]
    #[command(long_about = "\
Render a recording by another method.

Contact, loop, settings and device are those of the scene in the recording's metadata; flags change \
them. The object starts as it was at the first tick. What was recorded is drawn beside the methods.

Motion replay, the default: the device goes where it went, when it went there, whatever the force. That tells \
the force law on real motion and the energy it would have leaked, not how the hand would have \
answered.

Hand replay, --replay hand: the force of the hand is estimated from the motion and from the force that \
was sent, and the loop is closed again: the device moves under that hand and the new force, sampled \
when it was. The device has the mass of the scene's, or --device-mass. Ticks without a position and \
ticks that were lost are bridged; the force is less well known there, and a stretch longer than \
--largest-gap is refused. The report says how well the hand is known. Nothing in a recording says what \
the hand would have done elsewhere. It is taken to hold on to its motion with --hand-stiffness and \
--hand-damping; with 0 for both, its force stays what it was. What carries even the ideal device 1 m \
away is refused. Times count from the first position.")]
    #[command(after_help = "\
Examples:
  palpate replay tap.mcap --method hfcr
  palpate replay tap.mcap --method basic,coupled --plot replay.svg --out replay.csv
  palpate replay tap.mcap --method all --json
  palpate replay tap.mcap --replay hand --method basic,coupled --plot hand.svg
  palpate replay tap.mcap --replay hand --device-mass 0.3 --hand-stiffness 200 --hand-damping 5")]
    Replay(ReplayArguments),
    /// Write a page about a device: its timing, calibration, renderable contacts, a contact, warnings
    #[command(override_usage = "\
palpate report [RECORDING.mcap]... [--device-file <FILE.toml>] --out <PAGE.html> [OPTIONS]
       palpate report --device <NAME> [--device-file <FILE.toml>] --out <PAGE.html> [OPTIONS]")]
    #[command(long_about = "\
Write a page about a device: its timing, its calibration, what can be rendered, a contact, warnings.

The page is one file (HTML) without scripts and without a network: send it as it is, read it on a phone, \
print it on two sheets of A4. Everything on it comes from recordings, from a calibrated device file, or \
from a simulation with their numbers, and the page says which. Each warning has a remedy.

With --device, a short session is recorded first, as `palpate record` does, with the same safety, \
supervisor and watchdog; 5 s unless --duration says otherwise. The force comes on when the device is moved into \
the wall at 0, or into what the --scene has. The recording stays beside the page.

What can be rendered is a coarse map with the mass, period, delay, lag, gain, friction and sensor of this \
device. On a terminal a bar shows the part of the work, the steps that are done and the time; elsewhere a line on standard \
error does, after 30 s and whenever the time has doubled. The page says what was computed, its resolution, and how long \
it took.")]
    #[command(after_help = "\
Examples:
  palpate report tap.mcap --out device.html
  palpate report tap.mcap --device-file device.toml --calibration fit.json --out device.html
  palpate report --device-file device.toml --name 'Arm no. 7' --json
  palpate report --device simulated --scene wall.toml --duration 2 --out device.html")]
    Report(Box<ReportArguments>),
    /// Find the best damping of a method for a scene, and draw the whole curve
    #[command(long_about = "\
Find the damping of a method that suits a scene, and draw the whole curve.

What is varied is B of virtual-damper, b of hfcr, or the cap of popc and popc-ref. Each value is \
simulated from 21 start heights around the scene's own (the gap changed by up to 5 %), since a \
value that is best at one height may be bad at the next; the best is the one of least median. The flag of the damping that is looked for \
has no place here; --from and --to say where to look.

On a world it is the damping of virtual-damper, virtual-coupling or god-object, for the latter two with \
each of several couplings, judged on the scene as it is.")]
    #[command(after_help = "\
Examples:
  palpate tune experiments/fig2.toml --method virtual-damper --plot damper.svg
  palpate tune experiments/experiment2.toml --method hfcr --to 2 --least leak
  palpate tune experiments/experiment1.toml --method popc-ref --from 0.05 --to 15 --steps 300 --json
  palpate tune experiments/worlds/paddle.toml --method god-object --plot god-object.svg")]
    Tune(TuneArguments),
    /// Evaluate methods on random plants
    #[command(long_about = "\
Judge methods on plants drawn at random.

Device, hand, object, loop and sensor are drawn over the whole range that desktop devices have; \
docs/suite.md says how. Each plant is simulated over its first three collisions by every method \
with its default settings, without delay and with one sample of it, which the renderer models or not, and judged against the ideal \
of the same plant. The same seed gives the same plants for ever, and plant i is the same whatever \
the number of plants; so is every digit of the results, whatever the number of threads \
(RAYON_NUM_THREADS).

--columns names variants of methods to compare: a TOML file with a table for each, its name that \
of the column, with `method` and the settings that scenes have under [methods.NAME]. In place of a \
damping may stand a list of dampings, or `damping_over_k_t`, one number or a list: of a list the one \
that is best on each plant counts, which is found with knowledge of the ideal. A column may have a \
`guard`, too.")]
    #[command(after_help = "\
Examples:
  palpate suite --plants 40 --seeds 7
  palpate suite --plants 20 --seed 7 --method hfcr,virtual-damper --plot suite.svg --out suite.csv
  palpate suite --plants 5 --method hfcr --write-scenes plants --json")]
    Suite(SuiteArguments),
    /// Evaluate methods on scenes from 21 start heights
    #[command(long_about = "\
Judge methods on scenes from 21 start heights.

The gap between device and object is changed by up to 5 %: an error that holds at one height only \
is an accident. --model-mass-factor tells the renderer a wrong mass of the device. Settings are the \
scene's.")]
    #[command(after_help = "\
Examples:
  palpate heights experiments/fig2.toml experiments/experiment1.toml --model-mass-factor 1.5
  palpate heights experiments/experiment2.toml --method hfcr,hfcr-mod-st --json")]
    Heights(HeightsArguments),
    /// Vary one quantity of a scene, and show the effect on each method
    #[command(override_usage = "\
palpate sweep <SCENE.toml> --over <QUANTITY> --values <NUMBERS> [OPTIONS]")]
    #[command(long_about = "\
Vary one quantity of a scene, and see what each method does.

For each value, the scene runs in closed loop and is judged against the ideal of that value. The column \
`rebound` is the largest energy of a rebound, divided by the energy of the ideal's first rebound. Up to 1.1 \
the bounce is stable, up to 2 almost stable, above that unstable. `diverged` is as in `simulate`.")]
    #[command(after_help = "\
Examples:
  palpate sweep experiments/fig4.toml --over friction --values 1,10 --collisions 8 --method seh
  palpate sweep experiments/fig5.toml --over box --values 0.1,0.11,0.5 --method hfcr,coupled
  palpate sweep experiments/fig2.toml --over damping --values 0,0.03 --method hfcr --heights --json")]
    Sweep(SweepArguments),
    /// Check the numbers that the paper claims
    #[command(long_about = "\
Check the numbers that the paper claims.

Each claim is computed anew on the scenes of experiments/, with what it takes for the claim to hold. A \
claim that does not hold here is no fault of this program: the exit code is 0.")]
    #[command(after_help = "\
Example:
  palpate claims")]
    Claims(ClaimsArguments),
    /// Map which stiffness and mass each method can render
    #[command(long_about = "\
Map which stiffness and mass each method can render.

Each cell is a scene of its own: an object that bounces on the device, with kappa = K T²/m and \
Kc = K T²/M from 0.001 to 10, from 16 start heights, by every method, on a device without friction \
and on one with. What is mapped is the growth of the bounce's energy per collision, and how near \
the force comes to the ideal's. Ctrl-C keeps what is done; --resume goes on with it. Any part can \
be computed by itself, on any machine.")]
    #[command(after_help = "\
Examples:
  palpate map --cells 9
  palpate map --cells 9 --delay 1 --method hfcr,basic --out delayed.csv --json
  palpate map --cells 9 --shard 1/3 --resume")]
    Map(MapArguments),
    /// Report whether a device can render a contact, and by which method
    #[command(override_usage = "\
palpate advise --device-mass <kg> --period <s> [OPTIONS]")]
    #[command(long_about = "\
Ask whether a device can render a contact, and by which method.

Answers in words, then in tables: what each method does with the stiffness and the mass you would \
like, with which damping, and how stiff and how light it can go on this device. It is the map's own \
scene, an object that bounces on the device in a hand without damping, searched along stiffness \
and mass. Classical bounds of walls stand below.")]
    #[command(after_help = "\
Examples:
  palpate advise --device-mass 0.3 --period 0.002 --stiffness 2000 --mass 0.05
  palpate advise --device-mass 0.25 --period 0.02 --viscous-friction 0.5 --json")]
    Advise(AdviseArguments),
    /// Draw a figure of the paper
    #[command(after_help = "\
Examples:
  palpate figure fig1
  palpate figure fig4
  palpate figure fig2 --plot fig2.svg --json")]
    Figure(FigureArguments),
    /// Show the main results, without any input
    #[command(after_help = "\
Example:
  palpate demo --out-dir first-look")]
    Demo(DemoArguments),
    /// Print a completion script for a shell
    #[command(after_help = "\
Example:
  palpate completions bash > ~/.local/share/bash-completion/completions/palpate")]
    Completions(CompletionArguments),
}
