//! Effect of the contacts and fields on a tool over an interval.

use crate::WorldRenderer;
use crate::geometry::rigid::Vector3;
use crate::integration::moving::Moving;

/// Effect of the contacts and fields on a tool over an interval.
pub(super) struct Impulse {
    /// Impulse `[N s]`.
    pub linear: Vector3,
    /// First moment of the impulse about the interval's beginning `[N s^2]`.
    moment: Vector3,
    /// Angular impulse about the mass centre; only for a tool that turns `[N m s]`.
    pub angular: Vector3,
    /// Work `[J]`.
    pub work: f64,
    /// Whether the tool was touched, or in a field.
    pub touched: bool,
}

impl Impulse {
    /// Sums the effects of all contacts and fields of `moving`.
    pub fn on(moving: &Moving, renderer: &WorldRenderer, tool: usize) -> Self {
        let mut sum = Self {
            linear: Vector3::zeros(),
            moment: Vector3::zeros(),
            angular: Vector3::zeros(),
            work: 0.0,
            touched: false,
        };
        for &number in moving.nearby.recent() {
            let (point, touch) = (&renderer.points[number], &moving.touches[number]);
            if let Some(sign) = point.sign_on(tool) {
                sum.linear += touch.past.impulse * sign;
                sum.moment += touch.past.moment * sign;
                sum.angular += touch.past.angular_impulse;
                sum.work += touch.past.work_on_tool;
                sum.touched |= !touch.is_apart() || touch.past.impulse != Vector3::zeros();
            }
        }
        for field in moving.fields.iter().filter(|field| field.tool == tool) {
            sum.linear += field.past.impulse;
            sum.moment += field.past.moment;
            sum.work += field.past.work;
            sum.touched |= field.acts();
        }
        sum
    }

    /// Returns the moment by which the impulse comes earlier than that of a constant force, in an interval of `h` `[s]`
    /// `[N s^2]`.
    pub fn lead(&self, h: f64) -> Vector3 {
        self.linear * (0.5 * h) - self.moment
    }
}
