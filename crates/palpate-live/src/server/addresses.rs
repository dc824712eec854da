//! Addresses by which a server is reached that listens on all of them.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};

/// The address to open on this machine: `listened` itself, or the loopback where that is every address
/// of the machine (0.0.0.0 or [::]), which a browser cannot open.
pub fn here(listened: SocketAddr) -> SocketAddr {
    let ip = match listened.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(ip) if ip.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        ip => ip,
    };
    SocketAddr::new(ip, listened.port())
}

/// The address from which this machine would reach the network, for a server that listens on every
/// address; `None` for others, and for a machine without a network.
pub fn on_the_network(listened: SocketAddr) -> Option<SocketAddr> {
    // Addresses for examples, in no network: a connected UDP socket has an address and sends nothing.
    let (any, far): (IpAddr, IpAddr) = match listened.ip() {
        ip if !ip.is_unspecified() => return None,
        IpAddr::V4(_) => (
            Ipv4Addr::UNSPECIFIED.into(),
            Ipv4Addr::new(192, 0, 2, 1).into(),
        ),
        IpAddr::V6(_) => (
            Ipv6Addr::UNSPECIFIED.into(),
            Ipv6Addr::new(0x2001, 0xdb8, 0, 0, 0, 0, 0, 1).into(),
        ),
    };
    let socket = UdpSocket::bind((any, 0)).ok()?;
    socket.connect((far, 9)).ok()?;
    let ip = socket.local_addr().ok()?.ip();
    let is_of_use = !ip.is_unspecified() && !ip.is_loopback();
    is_of_use.then(|| SocketAddr::new(ip, listened.port()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_address_is_opened_by_the_loopback_and_others_by_themselves() {
        for (listened, opened) in [
            ("0.0.0.0:7777", "127.0.0.1:7777"),
            ("[::]:80", "[::1]:80"),
            ("127.0.0.1:1", "127.0.0.1:1"),
            ("192.168.1.5:2", "192.168.1.5:2"),
        ] {
            let listened: SocketAddr = listened.parse().unwrap();
            assert_eq!(here(listened).to_string(), opened);
            if let Some(address) = on_the_network(listened) {
                assert!(listened.ip().is_unspecified());
                assert!(!address.ip().is_unspecified() && !address.ip().is_loopback());
                assert_eq!(address.port(), listened.port());
            }
        }
    }
}
