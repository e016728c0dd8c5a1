//! A request of HTTP/1.1 (RFC 9112), and the check whether it may be answered.

use super::response::Answer;
use super::token::Token;

/// The head of a request. Bodies are ignored.
#[derive(Debug)]
pub struct Request<'a> {
    pub method: &'a str,
    target: &'a str,
    headers: Vec<(&'a str, &'a str)>,
}

impl<'a> Request<'a> {
    /// Reads the lines up to the empty one.
    pub fn parse(head: &'a [u8]) -> Option<Self> {
        let mut lines = std::str::from_utf8(head).ok()?.lines();
        let words: Vec<&str> = lines.next()?.split(' ').collect();
        let [method, target, version] = words[..] else { return None };
        let headers = lines.take_while(|line| !line.is_empty()).map(header);
        let headers = headers.collect::<Option<_>>()?;
        matches!(version, "HTTP/1.1" | "HTTP/1.0").then_some(Self { method, target, headers })
    }

    fn values(&self, name: &str) -> impl Iterator<Item = &'a str> {
        self.headers
            .iter()
            .filter(move |(other, _)| other.eq_ignore_ascii_case(name))
            .map(|(_, value)| *value)
    }
}

/// Splits a header line into name and value. Names have no spaces: so lines that continue the one before are
/// refused, as the standard has it.
fn header(line: &str) -> Option<(&str, &str)> {
    let (name, value) = line.split_once(':')?;
    let is_name = !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_graphic());
    is_name.then(|| (name, value.trim()))
}

/// Access check of the server.
#[derive(Debug)]
pub struct Door {
    pub port: u16,
    pub token: Token,
}

impl Door {
    /// Path that `request` asks for, behind the token; or the refusal.
    pub fn admit<'a>(&self, request: &Request<'a>) -> Result<&'a str, Answer> {
        let hosts: Vec<&str> = request.values("Host").collect();
        let [host] = hosts[..] else {
            return Err(Answer::text("400 Bad Request", "a request has one Host\n"));
        };
        // pages from elsewhere may lead their own name to this machine: they send that name
        if !self.is_own(host) {
            return Err(Answer::text("403 Forbidden", "this page is for 127.0.0.1 and localhost alone\n"));
        }
        // they may also embed what they cannot read: browsers tell
        if request.values("Sec-Fetch-Site").any(|site| !matches!(site, "same-origin" | "none")) {
            let text = "nothing here is for other pages: type the address, or copy it\n";
            return Err(Answer::text("403 Forbidden", text));
        }
        let behind = request.target.strip_prefix('/').unwrap_or_default();
        let (token, rest) =
            behind.split_once('/').map_or((behind, None), |(token, rest)| (token, Some(rest)));
        if !self.token.is(token) {
            let text =
                "the address is the one that `afterimage preview` has printed, with all of its letters\n";
            return Err(Answer::text("403 Forbidden", text));
        }
        rest.ok_or_else(|| Answer::moved(format!("/{}/", self.token)))
    }

    /// Returns true if `host` is the one in the page's address.
    fn is_own(&self, host: &str) -> bool {
        let (name, port) = host.split_once(':').unwrap_or((host, "80"));
        let is_name = name == "127.0.0.1" || name.eq_ignore_ascii_case("localhost");
        is_name && port == self.port.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PORT: u16 = 8080;

    fn door() -> Door {
        Door { port: PORT, token: Token::random().expect("random numbers") }
    }

    /// Result of a request with these lines behind its first one: the code, or the path behind the token.
    fn admitted(door: &Door, target: &str, headers: &str) -> Result<String, String> {
        let head = format!("GET {target} HTTP/1.1\r\n{headers}\r\n");
        let request = Request::parse(head.as_bytes()).ok_or("unread")?;
        let code = |answer: Answer| answer.status[..3].to_owned();
        door.admit(&request).map(str::to_owned).map_err(code)
    }

    #[test]
    fn one_host_is_answered_and_it_is_this_machine() {
        let door = door();
        let page = format!("/{}/", door.token);
        for host in ["127.0.0.1:8080", "localhost:8080", "LocalHost:8080"] {
            assert_eq!(admitted(&door, &page, &format!("hoST:{host} \r\n")), Ok(String::new()), "{host}");
        }
        for host in [
            "",
            "evil.example:8080",
            "127.0.0.1",
            "127.0.0.1:80",
            "127.0.0.1:evil.com",
            "127.0.0.1:8080:8080",
            "127.0.0.1:08080",
            "127.0.0.1.evil.example:8080",
            "evil@127.0.0.1:8080",
        ] {
            assert_eq!(admitted(&door, &page, &format!("Host: {host}\r\n")), Err("403".into()), "{host}");
        }
        for hosts in [
            "",
            "Host: evil.example\r\nHost: 127.0.0.1:8080\r\n",
            "Host: localhost:8080\r\nHost: localhost:8080\r\n",
        ] {
            assert_eq!(admitted(&door, &page, hosts), Err("400".into()), "{hosts}");
        }
        let usual = Door { port: 80, ..door };
        assert_eq!(
            admitted(&usual, &page, "Host: localhost\r\n"),
            Ok(String::new()),
            "browsers leave out 80"
        );
    }

    #[test]
    fn pages_from_elsewhere_get_nothing() {
        let door = door();
        let page = format!("/{}/frame/1/2", door.token);
        let from = |sites: &[&str]| {
            let lines: String = sites.iter().map(|site| format!("Sec-Fetch-Site: {site}\r\n")).collect();
            admitted(&door, &page, &format!("Host: localhost:8080\r\n{lines}"))
        };
        for sites in [&[][..], &["same-origin"], &["none"]] {
            assert_eq!(from(sites), Ok("frame/1/2".into()), "{sites:?}");
        }
        for sites in
            [&["cross-site"][..], &["same-site"], &[""], &["same-origin", "cross-site"], &["none, none"]]
        {
            assert_eq!(from(sites), Err("403".into()), "{sites:?}");
        }
    }

    #[test]
    fn nothing_is_shown_without_the_token() {
        let door = door();
        let get = |target: &str| admitted(&door, target, "Host: localhost:8080\r\n");
        let token = &door.token;
        for target in
            ["/", "/state", "//state", "*", "", "/0123/state", &format!("//{token}/"), &format!("{token}/")]
        {
            assert_eq!(get(target), Err("403".into()), "{target}");
        }
        assert_eq!(get(&format!("http://localhost:8080/{token}/")), Err("403".into()));
        assert_eq!(get(&format!("/{token}/state")), Ok("state".into()));
        assert_eq!(
            get(&format!("/{token}")),
            Err("308".into()),
            "an address that was copied without its end"
        );
    }

    #[test]
    fn what_is_no_request_is_not_read_as_one() {
        for head in [
            &b""[..],
            b"\r\n",
            b"GET\r\n\r\n",
            b"GET /\r\n\r\n",
            b"GET / HTTP/2\r\n\r\n",
            b"GET  / HTTP/1.1\r\n\r\n",
            b"GET / HTTP/1.1\r\nHost\r\n\r\n",
            b"GET / HTTP/1.1\r\nHost : a\r\n\r\n",
            b"GET / HTTP/1.1\r\nHost: a\r\n Host: b\r\n\r\n",
            b"GET / HTTP/1.1\r\n: a\r\n\r\n",
            b"GET /\xff HTTP/1.1\r\n\r\n",
        ] {
            assert!(Request::parse(head).is_none(), "{}", head.escape_ascii());
        }
    }
}
