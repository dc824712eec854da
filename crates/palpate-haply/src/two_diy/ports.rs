//! Serial ports that are there, and which of them may be a 2DIY.

use serialport::SerialPortType;

/// A serial port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// What to open.
    pub path: String,
    /// What it says of itself over USB, or how it is connected.
    pub description: String,
    /// What it may be.
    pub guess: Guess,
}

/// What a port may be; the likelier ones come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Guess {
    /// It calls itself an Arduino Zero, as the M0 board does.
    M0,
    /// It calls itself an Arduino Due, as the M3 and the development kit do.
    M3,
    /// An Arduino or a Haply that does not say which.
    Arduino,
    /// Another device on USB.
    OtherUsb,
    /// A port of the machine, or unknown.
    Other,
}

impl Guess {
    /// Whether it may well be a 2DIY.
    #[must_use]
    pub fn is_likely(self) -> bool {
        self <= Self::Arduino
    }
}

/// Vendors of the boards: Arduino (two numbers).
const ARDUINO: [u16; 2] = [0x2341, 0x2a03];

/// Every serial port of this machine, the likeliest 2DIY first.
///
/// # Errors
/// What the system says.
pub fn ports() -> Result<Vec<Port>, String> {
    // Where there is no such folder there are no ports, and the library would panic.
    if cfg!(target_os = "linux") && !std::path::Path::new("/sys/class/tty").is_dir() {
        return Ok(Vec::new());
    }
    let found = serialport::available_ports().map_err(|error| error.to_string())?;
    let mut ports: Vec<_> = found
        .into_iter()
        .map(|port| {
            let (description, guess) = describe(&port.port_type);
            Port {
                path: port.port_name,
                description,
                guess,
            }
        })
        .collect();
    ports.sort_by(|a, b| a.guess.cmp(&b.guess).then_with(|| a.path.cmp(&b.path)));
    Ok(ports)
}

fn describe(kind: &SerialPortType) -> (String, Guess) {
    match kind {
        SerialPortType::UsbPort(usb) => {
            let product = usb.product.as_deref().unwrap_or_default();
            let maker = usb.manufacturer.as_deref().unwrap_or_default();
            let names = format!("{maker} {product}");
            let guess = if product.contains("Arduino Zero") {
                Guess::M0
            } else if product.contains("Arduino Due") {
                Guess::M3
            } else if ARDUINO.contains(&usb.vid) || names.contains("Haply") {
                Guess::Arduino
            } else {
                Guess::OtherUsb
            };
            let number = format!("USB {:04x}:{:04x}", usb.vid, usb.pid);
            (format!("{number} {}", names.trim()).trim().into(), guess)
        }
        SerialPortType::BluetoothPort => ("Bluetooth".into(), Guess::Other),
        SerialPortType::PciPort => ("PCI".into(), Guess::Other),
        SerialPortType::Unknown => ("not on USB".into(), Guess::Other),
    }
}

#[cfg(test)]
mod tests {
    use serialport::UsbPortInfo;

    use super::*;

    #[test]
    fn boards_are_guessed_by_what_they_call_themselves() {
        let usb = |vid, maker: &str, product: &str| {
            let kind = SerialPortType::UsbPort(UsbPortInfo {
                vid,
                pid: 0x804d,
                serial_number: None,
                manufacturer: Some(maker.into()),
                product: Some(product.into()),
            });
            describe(&kind)
        };
        let (description, guess) = usb(0x2341, "Arduino LLC", "Arduino Zero");
        assert_eq!(description, "USB 2341:804d Arduino LLC Arduino Zero");
        assert_eq!(guess, Guess::M0);
        assert_eq!(usb(0x2341, "Arduino LLC", "Arduino Due").1, Guess::M3);
        assert_eq!(usb(0x2a03, "", "").1, Guess::Arduino);
        assert_eq!(usb(0x0403, "FTDI", "FT232R").1, Guess::OtherUsb);
        assert_eq!(describe(&SerialPortType::Unknown).1, Guess::Other);
        assert!(Guess::Arduino.is_likely() && !Guess::OtherUsb.is_likely());
    }
}
