//! Serial ports of this machine, and which of them may be a 2DIY.

#[cfg(target_os = "linux")]
mod sysfs;

/// A serial port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// Path to open.
    pub path: String,
    /// USB description, or the kind of connection.
    pub description: String,
    /// Probable device.
    pub guess: Guess,
}

/// Probable device on a port, in decreasing order of likelihood.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Guess {
    /// An Arduino Zero by its USB ids, as the M0 board is.
    M0,
    /// An Arduino Due by its USB ids, as the M3 and the development kit are.
    M3,
    /// An Arduino or a Haply of unknown model.
    Arduino,
    /// Another USB device.
    OtherUsb,
    /// A built-in port, or unknown.
    Other,
}

impl Guess {
    /// Returns whether the port is probably a 2DIY.
    #[must_use]
    pub fn is_likely(self) -> bool {
        self <= Self::Arduino
    }
}

/// USB vendor ids of the boards (Arduino has two).
const ARDUINO: [u16; 2] = [0x2341, 0x2a03];

/// Kind of connection of a port.
#[derive(Clone, Debug, PartialEq, Eq)]
// No system has all of them.
#[allow(dead_code)]
enum Connection {
    Usb(Usb),
    Bluetooth,
    Pci,
    Other,
}

/// USB identification of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Usb {
    vendor: u16,
    product: u16,
    manufacturer_name: String,
    product_name: String,
}

/// Returns every serial port of this machine, the likeliest 2DIY first.
///
/// # Errors
/// The error message of the operating system.
pub fn ports() -> Result<Vec<Port>, String> {
    let mut ports: Vec<_> = connected()?
        .into_iter()
        .map(|(path, connection)| {
            let (description, guess) = describe(&connection);
            Port {
                path,
                description,
                guess,
            }
        })
        .collect();
    ports.sort_by(|a, b| a.guess.cmp(&b.guess).then_with(|| a.path.cmp(&b.path)));
    Ok(ports)
}

/// Returns the paths to open and the kinds of connection.
#[cfg(target_os = "linux")]
fn connected() -> Result<Vec<(String, Connection)>, String> {
    use std::path::Path;
    sysfs::ports(Path::new("/sys/class/tty"), Path::new("/dev"))
        .map_err(|error| format!("/sys/class/tty: {error}"))
}

/// Returns the paths to open and the kinds of connection.
#[cfg(not(target_os = "linux"))]
fn connected() -> Result<Vec<(String, Connection)>, String> {
    use serialport::SerialPortType;
    let found = serialport::available_ports().map_err(|error| error.to_string())?;
    let connection = |kind| match kind {
        SerialPortType::UsbPort(usb) => Connection::Usb(Usb {
            vendor: usb.vid,
            product: usb.pid,
            manufacturer_name: usb.manufacturer.unwrap_or_default(),
            product_name: usb.product.unwrap_or_default(),
        }),
        SerialPortType::BluetoothPort => Connection::Bluetooth,
        SerialPortType::PciPort => Connection::Pci,
        SerialPortType::Unknown => Connection::Other,
    };
    Ok(found
        .into_iter()
        .map(|port| (port.port_name, connection(port.port_type)))
        .collect())
}

fn describe(connection: &Connection) -> (String, Guess) {
    match connection {
        Connection::Usb(usb) => {
            let names = format!("{} {}", usb.manufacturer_name, usb.product_name);
            let guess = if usb.product_name.contains("Arduino Zero") {
                Guess::M0
            } else if usb.product_name.contains("Arduino Due") {
                Guess::M3
            } else if ARDUINO.contains(&usb.vendor) || names.contains("Haply") {
                Guess::Arduino
            } else {
                Guess::OtherUsb
            };
            let number = format!("USB {:04x}:{:04x}", usb.vendor, usb.product);
            (format!("{number} {}", names.trim()).trim().into(), guess)
        }
        Connection::Bluetooth => ("Bluetooth".into(), Guess::Other),
        Connection::Pci => ("PCI".into(), Guess::Other),
        Connection::Other => ("not on USB".into(), Guess::Other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boards_are_guessed_by_what_they_call_themselves() {
        let usb = |vendor, maker: &str, product: &str| {
            describe(&Connection::Usb(Usb {
                vendor,
                product: 0x804d,
                manufacturer_name: maker.into(),
                product_name: product.into(),
            }))
        };
        let (description, guess) = usb(0x2341, "Arduino LLC", "Arduino Zero");
        assert_eq!(description, "USB 2341:804d Arduino LLC Arduino Zero");
        assert_eq!(guess, Guess::M0);
        assert_eq!(usb(0x2341, "Arduino LLC", "Arduino Due").1, Guess::M3);
        assert_eq!(usb(0x2a03, "", "").1, Guess::Arduino);
        assert_eq!(usb(0x0403, "FTDI", "FT232R").1, Guess::OtherUsb);
        assert_eq!(describe(&Connection::Other).1, Guess::Other);
        assert!(Guess::Arduino.is_likely() && !Guess::OtherUsb.is_likely());
    }
}
