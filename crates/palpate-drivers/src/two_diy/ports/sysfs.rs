//! Serial ports that the Linux kernel lists in `/sys/class/tty`.

use std::fs;
use std::io;
use std::path::Path;

use super::{Connection, Usb};

/// Returns the path in `dev` and the kind of connection for every terminal of `class` with hardware. Terminals without
/// hardware, such as consoles and pseudo-terminals, are omitted.
///
/// # Errors
/// `class` exists and cannot be read.
pub fn ports(class: &Path, dev: &Path) -> io::Result<Vec<(String, Connection)>> {
    let entries = match fs::read_dir(class) {
        Ok(entries) => entries,
        // A container may have no such folder, and then has no ports.
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(error),
    };
    let mut ports = Vec::new();
    for entry in entries {
        let name = entry?.file_name();
        let path = dev.join(&name);
        if !path.exists() {
            continue;
        }
        let connection = if name.to_string_lossy().starts_with("rfcomm") {
            Some(Connection::Bluetooth)
        } else {
            connection(&class.join(&name).join("device"))
        };
        if let Some(connection) = connection {
            ports.push((path.to_string_lossy().into_owned(), connection));
        }
    }
    Ok(ports)
}

/// Returns the kind of connection of a terminal; `None` without known hardware.
fn connection(device: &Path) -> Option<Connection> {
    let device = device.canonicalize().ok()?;
    let subsystem = device.join("subsystem").canonicalize().ok()?;
    match subsystem.file_name()?.to_str()? {
        // Interface of a USB device with a built-in terminal, such as an Arduino.
        "usb" => usb(device.parent()?),
        // Port of a USB converter, below its interface.
        "usb-serial" => usb(device.parent()?.parent()?),
        "pci" => Some(Connection::Pci),
        "amba" | "pnp" | "serial-base" => Some(Connection::Other),
        _ => None,
    }
}

fn usb(device: &Path) -> Option<Connection> {
    let text = |name: &str| fs::read_to_string(device.join(name)).ok();
    let number = |name: &str| u16::from_str_radix(text(name)?.trim(), 16).ok();
    let name = |file: &str| text(file).unwrap_or_default().trim().to_owned();
    Some(Connection::Usb(Usb {
        vendor: number("idVendor")?,
        product: number("idProduct")?,
        manufacturer_name: name("manufacturer"),
        product_name: name("product"),
    }))
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;
    use std::path::PathBuf;

    use super::*;

    /// A `/sys` and a `/dev` like the kernel's.
    struct Machine(tempfile::TempDir);

    impl Machine {
        fn new() -> Self {
            let machine = Self(tempfile::tempdir().unwrap());
            for folder in ["class", "dev", "bus"] {
                fs::create_dir(machine.at(folder)).unwrap();
            }
            machine
        }

        fn at(&self, path: &str) -> PathBuf {
            self.0.path().join(path)
        }

        /// Adds a terminal whose device is the folder `device` and belongs to `subsystem`.
        fn add(&self, terminal: &str, device: &str, subsystem: &str) {
            let bus = self.at("bus").join(subsystem);
            fs::create_dir_all(&bus).unwrap();
            fs::create_dir_all(self.at(device)).unwrap();
            symlink(bus, self.at(device).join("subsystem")).unwrap();
            let class = self.at("class").join(terminal);
            fs::create_dir(&class).unwrap();
            symlink(self.at(device), class.join("device")).unwrap();
            fs::write(self.at("dev").join(terminal), "").unwrap();
        }

        fn describe_usb(&self, device: &str, vendor: &str, product: &str, names: [&str; 2]) {
            fs::create_dir_all(self.at(device)).unwrap();
            for (file, text) in [
                ("idVendor", vendor),
                ("idProduct", product),
                ("manufacturer", names[0]),
                ("product", names[1]),
            ] {
                fs::write(self.at(device).join(file), format!("{text}\n")).unwrap();
            }
        }

        fn ports(&self) -> Vec<(String, Connection)> {
            let mut ports = ports(&self.at("class"), &self.at("dev")).unwrap();
            ports.sort_by(|a, b| a.0.cmp(&b.0));
            let dev = format!("{}/", self.at("dev").display());
            for (path, _) in &mut ports {
                *path = path.strip_prefix(&dev).unwrap().to_owned();
            }
            ports
        }
    }

    fn a_usb(vendor: u16, product: u16, maker: &str, name: &str) -> Connection {
        Connection::Usb(Usb {
            vendor,
            product,
            manufacturer_name: maker.into(),
            product_name: name.into(),
        })
    }

    #[test]
    fn a_port_says_how_it_is_connected() {
        let machine = Machine::new();
        machine.describe_usb(
            "devices/1-2",
            "2341",
            "804d",
            ["Arduino LLC", "Arduino Zero"],
        );
        machine.add("ttyACM0", "devices/1-2/1-2:1.0", "usb");
        machine.describe_usb("devices/1-3", "0403", "6001", ["FTDI", "FT232R USB UART"]);
        machine.add("ttyUSB0", "devices/1-3/1-3:1.0/ttyUSB0", "usb-serial");
        machine.add("rfcomm0", "devices/blue", "bluetooth");
        machine.add("ttyS0", "devices/00:05", "pnp");
        machine.add("ttyS4", "devices/0000:00", "pci");
        // A console, a phantom port, and a port without a device file.
        fs::create_dir(machine.at("class/tty0")).unwrap();
        fs::write(machine.at("dev/tty0"), "").unwrap();
        machine.add("ttyS9", "devices/serial8250", "platform");
        machine.add("ttyS1", "devices/00:06", "pnp");
        fs::remove_file(machine.at("dev/ttyS1")).unwrap();
        let zero = a_usb(0x2341, 0x804d, "Arduino LLC", "Arduino Zero");
        let converter = a_usb(0x0403, 0x6001, "FTDI", "FT232R USB UART");
        let expected = [
            ("rfcomm0", Connection::Bluetooth),
            ("ttyACM0", zero),
            ("ttyS0", Connection::Other),
            ("ttyS4", Connection::Pci),
            ("ttyUSB0", converter),
        ];
        assert_eq!(
            machine.ports(),
            expected.map(|(name, is)| (name.into(), is))
        );
    }

    #[test]
    fn a_device_without_names_is_listed_and_one_without_numbers_is_not() {
        let machine = Machine::new();
        machine.describe_usb("devices/1-2", "2341", "003d", ["", ""]);
        machine.add("ttyACM0", "devices/1-2/1-2:1.0", "usb");
        fs::remove_file(machine.at("devices/1-2/manufacturer")).unwrap();
        machine.describe_usb("devices/1-3", "no number", "003d", ["", ""]);
        machine.add("ttyACM1", "devices/1-3/1-3:1.0", "usb");
        let expected = [("ttyACM0".to_owned(), a_usb(0x2341, 0x003d, "", ""))];
        assert_eq!(machine.ports(), expected);
    }

    #[test]
    fn a_machine_without_the_folder_has_no_ports() {
        let machine = Machine::new();
        let nowhere = machine.at("nowhere");
        assert_eq!(ports(&nowhere, &machine.at("dev")).unwrap(), []);
        fs::write(&nowhere, "no folder").unwrap();
        assert!(ports(&nowhere, &machine.at("dev")).is_err());
    }
}
