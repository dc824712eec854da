//! Forces or torques in the actuation delay of the devices.

use palpate_core::{
    Actuation, Actuator, Ahead, Command, Governed, Held, LARGEST_DELAY, Piece, UnderWay, Uneven,
};

use crate::Vector;
use crate::geometry::rigid::Vector3;

/// Maximum number of pieces in which pending forces act before a new command.
const MAX_PIECES: usize = LARGEST_DELAY + 2;

/// Action on a tool over a time interval; vectors are along the world's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Acting {
    /// Mean of the commanded force, as the actuator delivers it `[N]`.
    pub intended: Vector3,
    /// Mean of the sent force, as delivered `[N]`.
    pub sent: Vector3,
    /// Moment by which the impulse comes earlier than that of a constant force: see [`Held::lead`] `[N s^2]`.
    pub lead: Vector3,
    /// Standard deviation of the impulse due to uncertain actuation `[N s]`.
    pub impulse_deviation: Vector3,
}

impl Acting {
    fn new(axes: &[Piece<f64>; 3]) -> Self {
        let of = |quantity: fn(&Piece<f64>) -> f64| Vector3::from(axes.each_ref().map(quantity));
        Self {
            intended: of(|piece| piece.intended),
            sent: of(|piece| piece.held.mean),
            lead: of(|piece| piece.held.lead),
            impulse_deviation: of(|piece| piece.held.impulse_deviation),
        }
    }

    /// Returns whether the whole intended force acted; false before the first command acts.
    pub fn is_whole(&self) -> bool {
        let square = self.intended.norm_squared();
        square > 0.0 && self.sent.dot(&self.intended) >= WHOLE_FROM * square
    }
}

/// Part of the intended force from which it counts as whole.
const WHOLE_FROM: f64 = 0.999;

/// Impulses that earlier commands still give a tool.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OnWay {
    /// Impulse in the direction of each axis `[N s]`.
    pub push: Vector3,
    /// Impulse against the direction of each axis, as a magnitude `[N s]`.
    pub pull: Vector3,
    /// Sum of the first moments about the sample, as magnitudes `[N s^2]`.
    pub moment: f64,
    /// Centroid of the impulse of the sample's own command, after the sample `[s]`.
    pub own_at: f64,
    /// Whether earlier forces still act when the own command begins.
    pub overlaps: bool,
}

/// Pending forces of each tool, along each axis.
#[derive(Clone, Debug)]
pub(crate) struct Commands {
    actuator: Actuator<f64>,
    tools: Vec<ToTool>,
}

/// Pending forces of a tool.
#[derive(Clone, Copy, Debug)]
struct ToTool {
    under_way: [UnderWay<f64>; 3],
    /// Forces that acted in the last interval between samples.
    passed: [Piece<f64>; 3],
    /// Forces that act before the next command, in time order.
    coming: [[Piece<f64>; 3]; MAX_PIECES],
    governed: [Option<Governed<f64>>; 3],
}

const NOTHING: Piece<f64> = Piece {
    duration: 0.0,
    intended: 0.0,
    held: Held {
        mean: 0.0,
        lead: 0.0,
        step: 0.0,
        step_moment: 0.0,
        impulse_deviation: 0.0,
    },
};

impl Commands {
    /// Creates the state from checked `actuation` parameters.
    pub fn new(tools: usize, actuation: &Actuation<f64>, period: f64) -> Self {
        let to_tool = ToTool {
            under_way: [UnderWay::nothing(); 3],
            passed: [NOTHING; 3],
            coming: [[NOTHING; 3]; MAX_PIECES],
            governed: [None; 3],
        };
        Self {
            actuator: Actuator::new(actuation, period),
            tools: vec![to_tool; tools],
        }
    }

    /// Copies the state of `other`, which has the same number of tools. It does not allocate.
    pub fn copy_from(&mut self, other: &Self) {
        self.actuator = other.actuator;
        for (tool, other) in self.tools.iter_mut().zip(&other.tools) {
            *tool = *other;
        }
    }

    /// Ends an interval of `h` `[s]` between two samples.
    pub fn pass(&mut self, h: f64) {
        for tool in &mut self.tools {
            for (passed, under_way) in tool.passed.iter_mut().zip(&mut tool.under_way) {
                *passed = under_way.pass(&self.actuator, h);
            }
        }
    }

    /// Returns the mean sent force on a tool over the last interval, or zero if the tool is not tracked.
    pub fn passed_or_none(&self, tool: usize) -> Vector3 {
        self.acting_or_none(tool).sent
    }

    /// Returns the action on a tool over the last interval, or none if the tool is not tracked.
    pub fn acting_or_none(&self, tool: usize) -> Acting {
        let tool = self.tools.get(tool);
        Acting::new(tool.map_or(&[NOTHING; 3], |tool| &tool.passed))
    }

    /// Returns the fraction of the intended force that acted on a tool over the last interval, 0 to 1; less than 1
    /// after limiting.
    pub fn part_sent(&self, tool: usize) -> f64 {
        let Some(tool) = self.tools.get(tool) else {
            return 1.0;
        };
        let Acting { intended, sent, .. } = Acting::new(&tool.passed);
        let square = intended.norm_squared();
        if square > 0.0 {
            (sent.dot(&intended) / square).clamp(0.0, 1.0)
        } else {
            1.0
        }
    }

    /// Returns the action on a tool over the last interval.
    pub fn passed(&self, tool: usize) -> Acting {
        Acting::new(&self.tools[tool].passed)
    }

    /// Computes the pieces that act before the command of this sample, which will act over `period` `[s]`. Returns
    /// the number of pieces.
    pub fn look_ahead(&mut self, period: f64) -> usize {
        let mut most = 0;
        for tool in &mut self.tools {
            for (axis, under_way) in tool.under_way.iter().enumerate() {
                let mut count = 0;
                let governed = Ahead::new(&self.actuator, under_way).until_own(period, |piece| {
                    if let Some(coming) = tool.coming.get_mut(count) {
                        coming[axis] = piece;
                        count += 1;
                    }
                });
                tool.governed[axis] = Some(governed);
                // Equal for all axes, which share one actuator.
                most = count;
            }
        }
        most
    }

    /// Returns the duration of a piece `[s]`.
    pub fn duration(&self, piece: usize) -> f64 {
        let first = self.tools.first().and_then(|tool| tool.coming.get(piece));
        first.map_or(0.0, |axes| axes[0].duration)
    }

    /// Returns the action on a tool during a piece.
    pub fn coming(&self, tool: usize, piece: usize) -> Acting {
        Acting::new(&self.tools[tool].coming[piece])
    }

    /// Returns the command of this sample whose impulse over its `period` `[s]` equals that of `mean` `[N]`.
    pub fn command(&self, tool: usize, mean: &Vector3, period: f64) -> Vector3 {
        let mut command = *mean;
        for (force, governed) in command.iter_mut().zip(&self.tools[tool].governed) {
            if let Some(governed) = governed {
                *force = governed.with_mean(*force, period);
            }
        }
        command / self.actuator.gain()
    }

    /// Returns the command of this sample that the actuator delivers as `force` `[N]`.
    pub fn for_force(&self, force: &Vector3) -> Vector3 {
        force / self.actuator.gain()
    }

    /// Returns whether a pending force acts on a tool before the command of this sample.
    pub fn is_expected(&self, tool: usize) -> bool {
        let under_way = self.tools.get(tool).map(|tool| tool.under_way.iter());
        under_way
            .into_iter()
            .flatten()
            .any(|axis| Ahead::new(&self.actuator, axis).is_awaited())
    }

    /// Returns the sums over all axes of the bounds on the force on a tool in an interval of `h` `[s]` that is about to
    /// [`pass`](Self::pass). 0 if the tool is not tracked.
    pub fn uneven(&self, tool: usize, h: f64) -> Uneven<f64> {
        let mut sum = Uneven::default();
        for axis in self.tools.get(tool).iter().flat_map(|tool| &tool.under_way) {
            let Uneven { course, size } = axis.uneven(&self.actuator, h);
            sum.course += course;
            sum.size += size;
        }
        sum
    }

    /// Returns the impulses that earlier commands still give a tool, in addition to a command over `period` `[s]`. 0 if
    /// the tool is not tracked.
    pub fn ahead(&self, tool: usize, period: f64) -> OnWay {
        let mut on_way = OnWay::default();
        for (axis, under_way) in self
            .tools
            .get(tool)
            .iter()
            .flat_map(|tool| tool.under_way.iter().enumerate())
        {
            let pending = Ahead::new(&self.actuator, under_way).pending(period);
            on_way.push[axis] = pending.push.impulse;
            on_way.pull[axis] = pending.pull.impulse;
            on_way.moment += pending.push.moment + pending.pull.moment;
            on_way.own_at = pending.own_at;
            on_way.overlaps = pending.overlaps;
        }
        on_way
    }

    /// Returns the ratio of delivered to commanded force.
    pub fn gain(&self) -> f64 {
        self.actuator.gain()
    }

    /// Sends the command of each tool, with its slope `[N/s]`; a missing slope counts as 0.
    pub fn send(&mut self, intended: &[Vector3], sent: &[Vector], slopes: &[Vector]) {
        let slopes = slopes.iter().chain(core::iter::repeat(&[0.0; 3]));
        let commands = intended.iter().zip(sent).zip(slopes);
        for (tool, ((intended, sent), slope)) in self.tools.iter_mut().zip(commands) {
            for (axis, under_way) in tool.under_way.iter_mut().enumerate() {
                under_way.send(Command {
                    intended: intended[axis],
                    sent: sent[axis],
                    slope: slope[axis],
                });
            }
        }
    }

    /// Replaces the last force by the force `[N]` and the slope `[N/s]` that a driver actually sent.
    pub fn correct(&mut self, tool: usize, sent: Vector3, slope: Vector3) {
        if let Some(tool) = self.tools.get_mut(tool) {
            for (axis, under_way) in tool.under_way.iter_mut().enumerate() {
                under_way.correct(sent[axis], slope[axis]);
            }
        }
    }
}
