//! Who may ask the server for anything: holders of the token, on this machine, from its own page.
//!
//! A page of another site can make a browser send requests here, and by DNS rebinding even under
//! the name of that site. Neither knows the token, and the first has another `Origin`, the second
//! another `Host`. All three are checked for every request, before it is looked at.

use anyhow::{Context as _, Result};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use std::fmt::Write as _;
use std::hint::black_box;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};

/// What a browser may do with a page: nothing comes from elsewhere, and no other page embeds it.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
    img-src 'self' blob: data:; connect-src 'self'; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'";

/// The headers of every answer.
pub(super) const HEADERS: [(HeaderName, HeaderValue); 6] = [
    (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY)),
    (header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff")),
    (header::REFERRER_POLICY, HeaderValue::from_static("no-referrer")),
    (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
    (
        HeaderName::from_static("cross-origin-opener-policy"),
        HeaderValue::from_static("same-origin"),
    ),
    (
        HeaderName::from_static("cross-origin-resource-policy"),
        HeaderValue::from_static("same-origin"),
    ),
];

/// The secret of a server and the names that it is known by.
#[derive(Debug)]
pub(super) struct Guard {
    token: String,
    /// The address of `--listen`; only loopback without.
    listen: Option<IpAddr>,
}

/// Why a request is refused. The answer has one sentence and no detail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    Host,
    Token,
    Origin,
}

impl Refusal {
    pub(super) const STATUS: StatusCode = StatusCode::FORBIDDEN;

    pub(super) fn sentence(self) -> &'static str {
        match self {
            Self::Host => "This server is not known by that name.\n",
            Self::Token => "Open the address that `rotund view` has printed.\n",
            Self::Origin => "Only the page of this server may connect.\n",
        }
    }
}

impl Guard {
    /// Creates a guard with a new token of 128 random bits.
    pub(super) fn new(listen: Option<IpAddr>) -> Result<Self> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes).context("the system has no random numbers for the token")?;
        let mut token = String::new();
        for byte in bytes {
            write!(token, "{byte:02x}")?;
        }
        Ok(Self { token, listen })
    }

    pub(super) fn token(&self) -> &str {
        &self.token
    }

    /// Returns the part of the path after the token, without a slash in front.
    pub(super) fn pass<'a>(&self, path: &'a str, headers: &HeaderMap) -> Result<&'a str, Refusal> {
        let host = single(headers, &header::HOST).ok_or(Refusal::Host)?;
        if !self.knows(host) {
            return Err(Refusal::Host);
        }
        let path = path.strip_prefix('/').unwrap_or(path);
        let (token, rest) = path.split_once('/').unwrap_or((path, ""));
        if equal_in_constant_time(token.as_bytes(), self.token.as_bytes()) {
            Ok(rest)
        } else {
            Err(Refusal::Token)
        }
    }

    /// Makes sure that a request for a socket comes from the page of this server.
    pub(super) fn pass_socket(headers: &HeaderMap) -> Result<(), Refusal> {
        let host = single(headers, &header::HOST).ok_or(Refusal::Host)?;
        let origin = single(headers, &header::ORIGIN).ok_or(Refusal::Origin)?;
        let own = origin.strip_prefix("http://").is_some_and(|it| it.eq_ignore_ascii_case(host));
        if own { Ok(()) } else { Err(Refusal::Origin) }
    }

    /// Whether a `Host` is a loopback name or the address of `--listen`, with any port: a tunnel
    /// has another. Where the server listens on all addresses, each has no name but its numbers.
    fn knows(&self, host: &str) -> bool {
        let Some(name) = without_port(host) else { return false };
        if name.eq_ignore_ascii_case("localhost") {
            return true;
        }
        let inner = name.strip_prefix('[').and_then(|name| name.strip_suffix(']'));
        let address: IpAddr = match inner {
            Some(v6) => match v6.parse::<Ipv6Addr>() {
                Ok(address) => address.into(),
                Err(_) => return false,
            },
            None => match name.parse::<Ipv4Addr>() {
                Ok(address) => address.into(),
                Err(_) => return false,
            },
        };
        let loopback = [IpAddr::from(Ipv4Addr::LOCALHOST), Ipv6Addr::LOCALHOST.into()];
        let listened = self.listen.is_some_and(|own| own.is_unspecified() || own == address);
        loopback.contains(&address) || listened
    }
}

/// Returns the host without its port, which must be a number.
fn without_port(host: &str) -> Option<&str> {
    let start = host.rfind(']').unwrap_or(0);
    match host[start..].find(':') {
        None => Some(host),
        Some(colon) => {
            let (name, port) = host.split_at(start + colon);
            port[1..].parse::<u16>().is_ok().then_some(name)
        }
    }
}

/// Returns the text of a header that is there exactly once.
fn single<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(value)
}

/// Compares secrets so that the time does not tell how many bytes agree.
fn equal_in_constant_time(a: &[u8], b: &[u8]) -> bool {
    let differing = a.iter().zip(b).fold(0, |sum, (a, b)| black_box(sum | (a ^ b)));
    a.len() == b.len() && differing == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(list: &[(HeaderName, &str)]) -> HeaderMap {
        let mut headers = HeaderMap::new();
        for (name, value) in list {
            headers.append(name, HeaderValue::from_str(value).expect("a header"));
        }
        headers
    }

    #[test]
    fn a_host_is_a_loopback_name_or_the_address_that_is_listened_on() {
        let table = [
            // why                            host               loopback  10.1.2.3  0.0.0.0
            ("a name", "localhost", true, true, true),
            ("a name with a port", "LOCALHOST:7171", true, true, true),
            ("an address", "127.0.0.1:80", true, true, true),
            ("of version 6", "[::1]:7171", true, true, true),
            ("without a port", "[::1]", true, true, true),
            ("the own address", "10.1.2.3:7171", false, true, true),
            ("another address", "10.1.2.4:7171", false, false, true),
            ("a name of a site", "rebind.example:7171", false, false, false),
            ("a name that starts like one", "localhost.example", false, false, false),
            ("an address in a name", "127.0.0.1.example", false, false, false),
            ("a user", "localhost@example", false, false, false),
            ("a port that is none", "localhost:x", false, false, false),
            ("short numbers", "127.1", false, false, false),
            ("half a bracket", "[::1", false, false, false),
            ("nothing", "", false, false, false),
        ];
        let guards = [None, Some([10, 1, 2, 3].into()), Some([0, 0, 0, 0].into())]
            .map(|listen| Guard::new(listen).expect("random numbers"));
        for (why, host, loopback, listened, all) in table {
            let found = guards.each_ref().map(|guard| guard.knows(host));
            assert_eq!(found, [loopback, listened, all], "{why}: {host}");
        }
    }

    #[test]
    fn only_the_whole_token_opens_a_path() {
        let guard = Guard::new(None).expect("random numbers");
        let host = headers(&[(header::HOST, "localhost")]);
        let token = guard.token().to_owned();
        assert_eq!(token.len(), 32);
        assert_eq!(guard.pass(&format!("/{token}/page/a.js"), &host), Ok("page/a.js"));
        assert_eq!(guard.pass(&format!("/{token}/"), &host), Ok(""));
        let last = if token.ends_with('0') { '1' } else { '0' };
        let other = format!("{}{last}", &token[..31]);
        for wrong in ["", "/", &token[..31], &other, &format!("{token}0"), "index.html"] {
            assert_eq!(guard.pass(&format!("/{wrong}/"), &host), Err(Refusal::Token), "{wrong}");
        }
        assert_ne!(Guard::new(None).expect("random numbers").token(), token, "each has its own");
    }

    #[test]
    fn a_socket_is_for_the_page_of_the_same_host() {
        let own = "localhost:7171";
        let table: [(&str, &[&str], Result<(), Refusal>); 6] = [
            ("its own", &["http://localhost:7171"], Ok(())),
            ("none", &[], Err(Refusal::Origin)),
            ("another port", &["http://localhost:7172"], Err(Refusal::Origin)),
            ("another site", &["http://example.org"], Err(Refusal::Origin)),
            ("a file", &["null"], Err(Refusal::Origin)),
            ("two", &["http://localhost:7171", "http://localhost:7171"], Err(Refusal::Origin)),
        ];
        for (why, origins, expected) in table {
            let origins = origins.iter().map(|&origin| (header::ORIGIN, origin));
            let list: Vec<_> = [(header::HOST, own)].into_iter().chain(origins).collect();
            assert_eq!(Guard::pass_socket(&headers(&list)), expected, "{why}");
        }
    }
}
