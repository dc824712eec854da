//! Access control: rejects foreign pages in the same browser and, if a token is required, requests without it.

use std::net::{IpAddr, SocketAddr};

use hyper::{HeaderMap, StatusCode, Uri, header};

/// Access rules of a server.
#[derive(Clone, Debug)]
pub struct Gate {
    port: u16,
    /// Names of this server in addition to `localhost` and addresses.
    hosts: Vec<String>,
    token: Option<String>,
}

/// Reason for rejecting a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal(pub StatusCode, pub &'static str);

const MISDIRECTED: Refusal = Refusal(
    StatusCode::MISDIRECTED_REQUEST,
    "unknown host name; `palpate live --allow-host NAME` allows it\n",
);
const FOREIGN: Refusal = Refusal(
    StatusCode::FORBIDDEN,
    "pages of another origin are not allowed\n",
);
const NO_TOKEN: Refusal = Refusal(
    StatusCode::UNAUTHORIZED,
    "the token is missing or wrong; open the address that `palpate live` has printed\n",
);

impl Gate {
    /// Creates the rules of a server that listens on `address` and also has the names `hosts`. If other machines can
    /// reach it, a random token is generated.
    ///
    /// # Errors
    /// The operating system provides no random numbers.
    pub fn new(address: SocketAddr, hosts: Vec<String>) -> Result<Self, getrandom::Error> {
        let token = if address.ip().is_loopback() {
            None
        } else {
            let mut bytes = [0; 16];
            getrandom::fill(&mut bytes)?;
            Some(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
        };
        Ok(Self {
            port: address.port(),
            hosts,
            token,
        })
    }

    /// Returns the token, if one is required.
    pub fn token(&self) -> Option<&str> {
        self.token.as_deref()
    }

    /// Accepts requests that are addressed to this server.
    ///
    /// # Errors
    /// The host is a foreign name.
    pub fn host<'a>(&self, headers: &'a HeaderMap) -> Result<&'a str, Refusal> {
        let mut all = headers.get_all(header::HOST).iter();
        let (Some(host), None) = (all.next(), all.next()) else {
            return Err(MISDIRECTED);
        };
        let host = host.to_str().map_err(|_| MISDIRECTED)?;
        let allowed = |allowed: &String| {
            allowed.eq_ignore_ascii_case(host)
                || format!("{allowed}:{}", self.port).eq_ignore_ascii_case(host)
        };
        let (name, port) = split(host).ok_or(MISDIRECTED)?;
        let is_own =
            port == self.port && (name.eq_ignore_ascii_case("localhost") || is_address(name));
        if is_own || self.hosts.iter().any(allowed) {
            Ok(host)
        } else {
            Err(MISDIRECTED)
        }
    }

    /// Accepts a page from this server, or a program, which sends no origin.
    ///
    /// # Errors
    /// The origin is another server.
    pub fn origin(&self, headers: &HeaderMap, host: &str) -> Result<(), Refusal> {
        let own = format!("http://{host}");
        let is_own =
            |origin: &header::HeaderValue| origin.as_bytes().eq_ignore_ascii_case(own.as_bytes());
        if headers.get_all(header::ORIGIN).iter().all(is_own) {
            Ok(())
        } else {
            Err(FOREIGN)
        }
    }

    /// Checks the token, if one is required.
    ///
    /// # Errors
    /// The token is missing or wrong.
    pub fn has_token(&self, uri: &Uri) -> Result<(), Refusal> {
        let Some(token) = &self.token else {
            return Ok(());
        };
        let given = uri
            .query()
            .unwrap_or("")
            .split('&')
            .find_map(|pair| pair.strip_prefix("token="))
            .unwrap_or("");
        if is_same(given.as_bytes(), token.as_bytes()) {
            Ok(())
        } else {
            Err(NO_TOKEN)
        }
    }
}

/// Whether two texts are the same, in a time that depends on their lengths only.
fn is_same(given: &[u8], secret: &[u8]) -> bool {
    let differences = given
        .iter()
        .zip(secret)
        .fold(0, |all, (given, secret)| all | (given ^ secret));
    given.len() == secret.len() && std::hint::black_box(differences) == 0
}

/// Name and port; without one it is 80.
fn split(host: &str) -> Option<(&str, u16)> {
    let (name, port) = match host.rsplit_once(':') {
        Some((name, port)) if !port.ends_with(']') => (name, port.parse().ok()?),
        _ => (host, 80),
    };
    Some((name, port))
}

/// Returns whether the name is an IP address, which cannot be redirected by DNS.
fn is_address(name: &str) -> bool {
    match name
        .strip_prefix('[')
        .and_then(|name| name.strip_suffix(']'))
    {
        Some(inside) => inside.parse::<std::net::Ipv6Addr>().is_ok(),
        None => name
            .parse::<IpAddr>()
            .is_ok_and(|address| address.is_ipv4()),
    }
}

#[cfg(test)]
mod tests {
    use hyper::header::HeaderValue;

    use super::*;

    fn gate(address: &str, hosts: &[&str]) -> Gate {
        let hosts = hosts.iter().map(|host| (*host).to_owned()).collect();
        Gate::new(address.parse().unwrap(), hosts).unwrap()
    }

    fn headers(name: header::HeaderName, value: &str) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(name, HeaderValue::from_str(value).unwrap());
        headers
    }

    #[test]
    fn a_host_is_an_address_or_localhost_with_the_port_or_a_name_that_was_allowed() {
        let gate = gate("127.0.0.1:7777", &["lab", "tunnel:8080"]);
        for host in [
            "127.0.0.1:7777",
            "localhost:7777",
            "LOCALHOST:7777",
            "[::1]:7777",
            "192.168.1.5:7777",
            "lab:7777",
            "tunnel:8080",
        ] {
            assert!(gate.host(&headers(header::HOST, host)).is_ok(), "{host}");
        }
        for host in [
            "evil.example:7777",
            "localhost",
            "localhost:80",
            "127.0.0.1:7778",
            "127.0.0.1.evil.example:7777",
            "localhost.evil.example:7777",
            "::1:7777",
            "[localhost]:7777",
            "tunnel:7777x",
            "lab:8080",
            "",
            ":7777",
        ] {
            let headers = headers(header::HOST, host);
            assert_eq!(gate.host(&headers), Err(MISDIRECTED), "{host}");
        }
        assert_eq!(gate.host(&HeaderMap::new()), Err(MISDIRECTED));
        let mut two = headers(header::HOST, "localhost:7777");
        two.append(header::HOST, HeaderValue::from_static("localhost:7777"));
        assert_eq!(gate.host(&two), Err(MISDIRECTED));
    }

    #[test]
    fn an_origin_is_this_server_or_none() {
        let gate = gate("127.0.0.1:7777", &[]);
        let host = "localhost:7777";
        assert!(gate.origin(&HeaderMap::new(), host).is_ok());
        let from = |origin| gate.origin(&headers(header::ORIGIN, origin), host);
        assert!(from("http://localhost:7777").is_ok());
        for origin in [
            "http://evil.example",
            "https://localhost:7777",
            "http://localhost:7778",
            "http://127.0.0.1:7777",
            "http://localhost:7777.evil.example",
            "null",
            "",
        ] {
            assert_eq!(from(origin), Err(FOREIGN), "{origin}");
        }
    }

    #[test]
    fn a_token_is_asked_for_where_others_can_come() {
        let uri = |query: &str| format!("/live{query}").parse::<Uri>().unwrap();
        assert!(gate("127.0.0.1:1", &[]).has_token(&uri("")).is_ok());
        assert!(gate("[::1]:1", &[]).has_token(&uri("")).is_ok());
        let open = gate("0.0.0.0:1", &[]);
        let token = open.token().unwrap();
        assert_eq!(token.len(), 32);
        assert_ne!(gate("0.0.0.0:1", &[]).token(), open.token());
        assert!(open.has_token(&uri(&format!("?token={token}"))).is_ok());
        assert!(open.has_token(&uri(&format!("?a=b&token={token}"))).is_ok());
        let mut wrong = token.to_owned().into_bytes();
        wrong[31] ^= 1;
        let wrong = String::from_utf8(wrong).unwrap();
        for query in [
            String::new(),
            "?token=".into(),
            format!("?token={}", &token[1..]),
            format!("?token={token}0"),
            format!("?token={wrong}"),
            format!("?tokens={token}"),
        ] {
            assert_eq!(open.has_token(&uri(&query)), Err(NO_TOKEN), "{query}");
        }
    }
}
