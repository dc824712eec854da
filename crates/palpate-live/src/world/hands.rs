//! The hands that pages lead: one for each device of a world that has one.

use palpate_device::Vector;
use palpate_scene::world::WorldScene;
use palpate_study::sim::device::SpatialHand;

use crate::hub::ClientId;

/// Tolerance on the length of a quaternion: a page sends few digits.
const LENGTH_SLACK: f64 = 1e-3;
/// Reach of a hand along each axis, from the initial position of the tool `[m]`.
const REACH: f64 = 1.0;

/// The hands of the devices of a world, in their order. Each is led by the client that moved it last.
pub struct Hands(Vec<Led>);

/// A device, and its hand if a page leads it.
struct Led {
    hand: Option<SpatialHand>,
    /// Initial position of its tool `[m]`.
    start: Vector,
    turns: bool,
    /// Client that moved the hand last.
    holder: Option<ClientId>,
}

impl Hands {
    /// The hands that there are of the devices of `scene`; a device without one is not led.
    pub fn new(scene: &WorldScene, hands: &[Option<SpatialHand>]) -> Self {
        let led = scene
            .devices
            .iter()
            .enumerate()
            .map(|(number, device)| Led {
                hand: hands.get(number).cloned().flatten(),
                start: device.position,
                turns: device.turning.is_some(),
                holder: None,
            });
        Self(led.collect())
    }

    /// The hand of each device, in their order.
    pub fn iter(&self) -> impl Iterator<Item = Option<&SpatialHand>> {
        self.0.iter().map(|led| led.hand.as_ref())
    }

    /// Whether every device is led from a page.
    pub fn are_all_led(&self) -> bool {
        self.iter().all(|hand| hand.is_some())
    }

    /// Each hand holds its device where it begins.
    pub fn begin(&self) {
        for led in &self.0 {
            if let Some(hand) = &led.hand {
                hand.move_to(led.start);
                hand.turn_back();
            }
        }
    }

    /// Removes a client: the hands that it moved last release their devices.
    pub fn gone(&mut self, client: ClientId) {
        for led in &mut self.0 {
            if led.holder == Some(client) {
                led.holder = None;
                if let Some(hand) = &led.hand {
                    hand.disable_output();
                }
            }
        }
    }

    /// Moves the hand of a device to a position, or releases the device.
    pub fn lead(
        &mut self,
        client: ClientId,
        device: usize,
        place: Option<Vector>,
    ) -> Result<(), String> {
        let led = self.of(device)?;
        let hand = led.hand()?;
        led.holder = match place {
            None => {
                hand.disable_output();
                None
            }
            Some(place) => {
                let start = led.start;
                let reaches = place
                    .iter()
                    .zip(start)
                    .all(|(to, from)| (to - from).abs() <= REACH);
                if !reaches {
                    return Err(format!(
                        "position_m is {place:?}; allowed: within {REACH} m of {start:?} along each axis, or null"
                    ));
                }
                hand.move_to(place);
                Some(client)
            }
        };
        Ok(())
    }

    /// Turns the hand of a device, for any client, or resets its orientation.
    pub fn turn(&mut self, device: usize, orientation: Option<[f64; 4]>) -> Result<(), String> {
        let led = self.of(device)?;
        let hand = led.hand()?;
        if !led.turns {
            return Err("this device has three axes and no orientation".into());
        }
        match orientation {
            None => hand.turn_back(),
            Some(orientation) => {
                let length = orientation
                    .iter()
                    .map(|part| part * part)
                    .sum::<f64>()
                    .sqrt();
                let is_unit = (length - 1.0).abs() <= LENGTH_SLACK;
                if !is_unit {
                    return Err(format!(
                        "orientation is {orientation:?}; allowed: a quaternion of length 1, or null"
                    ));
                }
                hand.turn_to(orientation);
            }
        }
        Ok(())
    }

    fn of(&mut self, device: usize) -> Result<&mut Led, String> {
        let most = self.0.len().max(1) - 1;
        let led = self.0.get_mut(device);
        led.ok_or_else(|| format!("device is {device}; allowed: 0 to {most}"))
    }
}

impl Led {
    fn hand(&self) -> Result<SpatialHand, String> {
        let hand = self.hand.clone();
        hand.ok_or_else(|| "this device cannot be moved from the page; use --device pointer".into())
    }
}

#[cfg(test)]
mod tests {
    use palpate_scene::world::WorldFile;

    use super::*;
    use crate::hub::Hub;

    /// The hands of a world whose two devices are led from a page, and of one whose second is not.
    fn hands(is_second_led: bool) -> (Hands, [SpatialHand; 2]) {
        let text = include_str!("../../../../experiments/worlds/pinch.toml");
        let scene = WorldFile::parse("pinch.toml", text).unwrap().scene;
        let own = [0, 1].map(|device: usize| SpatialHand::at(scene.devices[device].position));
        let [left, right] = own.clone();
        let second = Some(right).filter(|_| is_second_led);
        (Hands::new(&scene, &[Some(left), second]), own)
    }

    #[test]
    fn each_hand_follows_the_client_that_moved_it_last_and_no_other() {
        let (mut hands, [left, right]) = hands(true);
        let hub = Hub::default();
        let (one, other) = (hub.join().id, hub.join().id);
        let start = right.target().unwrap();
        hands.lead(one, 0, Some([0.0, 0.01, 0.02])).unwrap();
        assert_eq!(left.target(), Some([0.0, 0.01, 0.02]));
        assert_eq!(right.target(), Some(start));
        hands.lead(other, 1, Some([0.03, 0.0, 0.0])).unwrap();
        hands.gone(one);
        assert_eq!(left.target(), None);
        assert_eq!(right.target(), Some([0.03, 0.0, 0.0]));
        hands.lead(other, 1, None).unwrap();
        assert_eq!(right.target(), None);
        hands.begin();
        assert_eq!(right.target(), Some(start));
    }

    #[test]
    fn what_a_hand_cannot_do_is_refused_with_what_is_allowed() {
        let (mut hands, [_, right]) = hands(false);
        let client = Hub::default().join().id;
        assert!(!hands.are_all_led());
        let refused = hands.lead(client, 1, Some([0.0; 3])).unwrap_err();
        assert!(
            refused.contains("cannot be moved from the page"),
            "{refused}"
        );
        let refused = hands.lead(client, 2, None).unwrap_err();
        assert_eq!(refused, "device is 2; allowed: 0 to 1");
        let refused = hands.lead(client, 0, Some([2.0, 0.0, 0.0])).unwrap_err();
        assert!(refused.contains("within 1 m of [-0.0202"), "{refused}");
        let refused = hands.turn(0, Some([1.0, 0.0, 0.0, 0.0])).unwrap_err();
        assert!(refused.contains("three axes"), "{refused}");
        assert_eq!(right.target(), Some([0.0202, -0.0003, 0.016]));
    }
}
