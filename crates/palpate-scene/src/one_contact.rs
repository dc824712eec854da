//! Which scenes have one contact along one axis. The closed form renders these, and the world renderer all others.

use palpate_world::{IDENTITY, Party, Quaternion, Vector};

use crate::fault::{SceneErrors, Span};
use crate::raw::{RawBody, RawContact, RawScene};
use crate::source::Source;
use crate::world::per_axis::DeviceAxes;
use crate::world::shape::{RawShape, unit};

/// Tolerance on the cosine between an axis and a surface normal.
const ALONG: f64 = 1e-9;

/// The axis along which device and body move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OneAxis {
    /// The axes of the device: one.
    pub axes: DeviceAxes,
    /// Component of the outward surface normal along the axis: 1 or -1.
    pub normal: f64,
    /// Distance of the surface from the position of the body, along the normal `[m]`.
    pub offset: f64,
}

impl OneAxis {
    /// Returns the component of a vector along the axis.
    pub fn along(&self, vector: Vector) -> f64 {
        let first = self.axes.has.iter().position(|has| *has).unwrap_or(0);
        self.axes
            .own
            .map_or(vector[first], |own| dot(own[first], vector))
    }
}

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Reason why a scene has more than one contact along one axis.
#[derive(Clone, Debug)]
pub(crate) struct NotOneContact {
    /// The property of the scene that the closed form lacks.
    pub reason: String,
    /// Span of that property.
    pub span: Span,
}

impl NotOneContact {
    fn new(span: Span, reason: impl Into<String>) -> Self {
        Self {
            reason: reason.into(),
            span,
        }
    }
}

impl NotOneContact {
    /// Returns the error where one contact along one axis is needed.
    pub fn needed(&self, source: &Source) -> SceneErrors {
        let reason = &self.reason;
        let message = format!("one contact along one axis is needed here, but {reason}");
        source.error(self.span.clone(), message).into()
    }
}

impl RawScene {
    /// Returns the axis of a scene with one contact along one axis.
    ///
    /// # Errors
    /// The first reason why it has more.
    pub fn one_contact(&self) -> Result<OneAxis, NotOneContact> {
        let axes = self.one_axis_of_device()?;
        let [body] = &self.body[..] else {
            return Err(number_of(self.body.len(), ["body", "bodies"]));
        };
        if let Some(joint) = self.joint.first() {
            return Err(NotOneContact::new(joint.span(), "the scene has a joint"));
        }
        if let Some(field) = self.field.first() {
            return Err(NotOneContact::new(field.span(), "the scene has a field"));
        }
        let span = body.span();
        let body = body.get_ref();
        let moves_alike = body.axes.as_ref().map(|body| *body.get_ref() == axes);
        if !body.fixed && moves_alike != Some(true) {
            let (span, reason) = match &body.axes {
                None => (span, "the body has no `axes`, so it moves along all"),
                Some(axes) => (axes.span(), "body and device have different `axes`"),
            };
            return Err(NotOneContact::new(span, reason));
        }
        let axis = half_space_along(body, axes)?;
        self.one_plain_contact(body)?;
        let guard = self.render.guard.as_ref();
        if let Some(late) = guard.and_then(|guard| guard.late_samples.as_ref())
            && *late.get_ref() > 0
        {
            return Err(NotOneContact::new(
                late.span(),
                "the guard has late_samples",
            ));
        }
        Ok(axis)
    }

    /// Returns the axes of the scene's device, if it has one axis and a point as its tool.
    fn one_axis_of_device(&self) -> Result<DeviceAxes, NotOneContact> {
        let [device] = &self.device[..] else {
            return Err(number_of(self.device.len(), ["device", "devices"]));
        };
        let span = device.span();
        let device = device.get_ref();
        let axes = device
            .axes
            .as_ref()
            .map_or(DeviceAxes::WORLD, |axes| *axes.get_ref());
        let count = axes.has.iter().filter(|has| **has).count();
        if count != 1 {
            let span = device.axes.as_ref().map_or(span, |axes| axes.span());
            return Err(NotOneContact::new(
                span,
                format!("the device has {count} axes"),
            ));
        }
        if let Some(inertia) = &device.inertia_kg_m2 {
            return Err(NotOneContact::new(inertia.span(), "the device turns"));
        }
        if let Some(table) = &device.mass_table {
            return Err(NotOneContact::new(
                table.span(),
                "the device has a mass_table",
            ));
        }
        match &device.tool {
            Some(tool) if !tool.get_ref().is_point() => {
                Err(NotOneContact::new(tool.span(), "the tool is not a point"))
            }
            _ => Ok(axes),
        }
    }

    /// Rejects contacts other than one linear contact without friction between the device and `body`.
    fn one_plain_contact(&self, body: &RawBody) -> Result<(), NotOneContact> {
        let [contact] = &self.contact[..] else {
            return Err(number_of(self.contact.len(), ["contact", "contacts"]));
        };
        let device = self.device[0].get_ref().name.get_ref();
        let RawContact {
            between,
            damping_n_s_per_m,
            friction,
            ..
        } = contact.get_ref();
        let [one, other] = &between.get_ref().0;
        let is = |party: &Party, name: &str| match party {
            Party::Any => true,
            Party::Named(named) => named == name,
        };
        let body = body.name.get_ref();
        if !(is(one, device) && is(other, body) || is(one, body) && is(other, device)) {
            let reason = format!("the contact is not between {device} and {body}");
            return Err(NotOneContact::new(between.span(), reason));
        }
        for (key, what) in [(damping_n_s_per_m, "damping"), (friction, "friction")] {
            if let Some(key) = key
                && *key.get_ref() != 0.0
            {
                let reason = format!("the contact has {what}");
                return Err(NotOneContact::new(key.span(), reason));
            }
        }
        Ok(())
    }
}

/// Returns the error for another number of parts than one.
fn number_of(count: usize, [one, many]: [&str; 2]) -> NotOneContact {
    let reason = match count {
        0 => format!("the scene has no {one}"),
        count => format!("the scene has {count} {many}"),
    };
    NotOneContact::new(0..0, reason)
}

/// Returns the axis of a half-space whose normal is along the one of `axes`.
fn half_space_along(body: &RawBody, axes: DeviceAxes) -> Result<OneAxis, NotOneContact> {
    let RawShape::HalfSpace { normal, offset_m } = *body.shape.get_ref() else {
        let reason = "the body is not a half_space";
        return Err(NotOneContact::new(body.shape.span(), reason));
    };
    let orientation = body.orientation.as_ref();
    let orientation = unit(orientation.map_or(IDENTITY, |turn| *turn.get_ref()));
    let mut axis = OneAxis {
        axes,
        normal: 0.0,
        offset: offset_m,
    };
    let cosine = axis.along(rotated(orientation, unit(normal)));
    // A normal or an orientation without a direction has no cosine, or one of 0.
    let is_along = (cosine.abs() - 1.0).abs() <= ALONG;
    let turns = orientation.iter().map(|part| part * part).sum::<f64>() > 0.5;
    if !(is_along && turns && offset_m.is_finite()) {
        let reason = "the normal of the half_space is not along the axis of the device";
        return Err(NotOneContact::new(body.shape.span(), reason));
    }
    axis.normal = cosine.signum();
    Ok(axis)
}

/// Returns a vector turned by a unit quaternion [w, x, y, z].
fn rotated([w, x, y, z]: Quaternion, vector: Vector) -> Vector {
    let cross = |a: Vector, b: Vector| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let axis = [x, y, z];
    let once = cross(axis, vector);
    let twice = cross(axis, once);
    [0, 1, 2].map(|part| vector[part] + 2.0 * (w * once[part] + twice[part]))
}
