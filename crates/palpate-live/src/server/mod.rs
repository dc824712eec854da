//! The server: a page, and a WebSocket for each client. It runs on its own thread.

mod addresses;
mod client;
mod connections;
mod gate;
mod page;
mod upgrade;

use std::convert::Infallible;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::SyncSender;
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::header::HeaderValue;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode, header};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::oneshot;

use crate::hub::Hub;
use crate::session::Command;
use connections::Connections;
use gate::{Gate, Refusal};

/// The body of an answer.
type Body = Full<Bytes>;

/// Default address of the server.
pub const DEFAULT_ADDRESS: SocketAddr =
    SocketAddr::V4(SocketAddrV4::new(Ipv4Addr::LOCALHOST, 7777));
/// Most clients.
const MAX_CLIENTS: usize = 64;
/// Bytes that wait for a client outside this program: half a second of samples. More would be old.
const SEND_BUFFER: u32 = 64 << 10;
/// Connections that wait to be accepted.
const BACKLOG: u32 = 1024;

/// Reason why the server cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ListenError {
    /// The address cannot be listened on.
    #[error("{address}: {source}")]
    Address {
        /// The address.
        address: SocketAddr,
        /// Error of the operating system.
        source: io::Error,
    },
    /// There is no thread to serve on.
    #[error("no thread for the server: {0}")]
    Thread(io::Error),
    /// No token can be made.
    #[error("cannot generate a random token: {0}")]
    Randomness(getrandom::Error),
}

/// A bound address; connections are not accepted yet.
pub struct Listening {
    runtime: tokio::runtime::Runtime,
    listener: TcpListener,
    address: SocketAddr,
    gate: Gate,
}

impl Listening {
    /// Listens on `address`; `hosts` are names that the server is also called by.
    ///
    /// # Errors
    /// The address is in use or not this machine's, or the system refuses.
    pub fn on(address: SocketAddr, hosts: Vec<String>) -> Result<Self, ListenError> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(ListenError::Thread)?;
        let listen = || {
            let _inside = runtime.enter();
            let socket = match address {
                SocketAddr::V4(_) => TcpSocket::new_v4()?,
                SocketAddr::V6(_) => TcpSocket::new_v6()?,
            };
            socket.set_reuseaddr(true)?;
            // Accepted connections inherit this setting.
            socket.set_send_buffer_size(SEND_BUFFER)?;
            socket.bind(address)?;
            let listener = socket.listen(BACKLOG)?;
            let address = listener.local_addr()?;
            Ok((listener, address))
        };
        let (listener, address) =
            listen().map_err(|source| ListenError::Address { address, source })?;
        Ok(Self {
            runtime,
            listener,
            address,
            gate: Gate::new(address, hosts).map_err(ListenError::Randomness)?,
        })
    }

    /// The address that is listened on.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Returns the address of the page for a browser on this machine, including the token.
    #[must_use]
    pub fn url(&self) -> String {
        self.url_at(addresses::here(self.address))
    }

    /// Returns the address of the page for other machines, including the token, if the server listens on every address
    /// of this one; `None` otherwise, or if this machine is in no network.
    #[must_use]
    pub fn url_on_the_network(&self) -> Option<String> {
        addresses::on_the_network(self.address).map(|address| self.url_at(address))
    }

    fn url_at(&self, address: SocketAddr) -> String {
        let token = self.gate.token();
        let token = token.map_or(String::new(), |token| format!("?token={token}"));
        format!("http://{address}/{token}")
    }
}

/// Page at the root address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Home {
    /// That of one contact.
    Contact,
    /// That of a world.
    World,
}

/// A server on its thread. Dropping it ends it.
pub struct Server {
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// Time limit for notifying clients of the server's end.
const FAREWELL: Duration = Duration::from_millis(300);

impl Server {
    /// Serves what `hub` tells, and hands on what clients ask for.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(
        listening: Listening,
        hub: Arc<Hub>,
        commands: SyncSender<Command>,
        home: Home,
    ) -> Result<Self, ListenError> {
        let Listening {
            runtime,
            listener,
            gate,
            ..
        } = listening;
        let (stop, stopped) = oneshot::channel();
        let served = Arc::new(Served {
            gate,
            hub,
            commands,
            home,
            clients: AtomicUsize::new(0),
        });
        let thread = Builder::new()
            .name("palpate server".to_owned())
            .spawn(move || {
                runtime.block_on(async {
                    accept(listener, served, stopped).await;
                    tokio::time::sleep(FAREWELL).await;
                });
                runtime.shutdown_timeout(Duration::ZERO);
            })
            .map_err(ListenError::Thread)?;
        Ok(Self {
            stop: Some(stop),
            thread: Some(thread),
        })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop.take();
        if let Some(thread) = self.thread.take() {
            // The thread returns no value.
            let _ = thread.join();
        }
    }
}

/// State that all connections share.
struct Served {
    gate: Gate,
    hub: Arc<Hub>,
    commands: SyncSender<Command>,
    home: Home,
    clients: AtomicUsize,
}

async fn accept(listener: TcpListener, served: Arc<Served>, mut stopped: oneshot::Receiver<()>) {
    let mut connections = Connections::default();
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            _ = &mut stopped => return,
        };
        match accepted {
            Ok((stream, _)) => {
                let task = tokio::spawn(answer_one(stream, Arc::clone(&served)));
                connections.add(task.abort_handle());
            }
            Err(_) => {
                // The process is probably out of file descriptors: close connections.
                connections.make_room(0);
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        }
    }
}

/// Answers the one request of a connection.
async fn answer_one(stream: TcpStream, served: Arc<Served>) {
    // Send a frame without delay.
    let _ = stream.set_nodelay(true);
    let service = service_fn(move |request| {
        let answer = answer(&served, request);
        async move { Ok::<_, Infallible>(answer) }
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(connections::HEAD_PATIENCE)
        .max_buf_size(16 << 10)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    // Slow or invalid requests end here.
    let _ = tokio::time::timeout(connections::PATIENCE, connection).await;
}

fn answer(served: &Arc<Served>, request: Request<Incoming>) -> Response<Body> {
    let mut connect = "ws:".to_owned();
    let answered = match served.gate.host(request.headers()) {
        Ok(host) => {
            connect = format!("ws://{host}");
            let host = host.to_owned();
            route(served, request, &host)
        }
        Err(refusal) => Err(refusal),
    };
    let mut response = answered.unwrap_or_else(|Refusal(status, text)| {
        let mut response = Response::new(Body::from(text));
        *response.status_mut() = status;
        let plain = HeaderValue::from_static("text/plain; charset=utf-8");
        response.headers_mut().insert(header::CONTENT_TYPE, plain);
        if status == StatusCode::METHOD_NOT_ALLOWED {
            let get = HeaderValue::from_static("GET");
            response.headers_mut().insert(header::ALLOW, get);
        }
        response
    });
    let policy = format!(
        "default-src 'self'; connect-src 'self' {connect}; img-src 'self' data:; base-uri 'none'; \
         form-action 'none'; frame-ancestors 'none'"
    );
    let headers = response.headers_mut();
    // A host that was let in is a header's text already.
    if let Ok(policy) = HeaderValue::try_from(policy) {
        headers.insert(header::CONTENT_SECURITY_POLICY, policy);
    }
    for (name, value) in [
        (header::CACHE_CONTROL, "no-cache"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if response.status() != StatusCode::SWITCHING_PROTOCOLS {
        // One request is answered, and a browser opens another connection for its next.
        let close = HeaderValue::from_static("close");
        response.headers_mut().insert(header::CONNECTION, close);
    }
    response
}

fn route(
    served: &Arc<Served>,
    request: Request<Incoming>,
    host: &str,
) -> Result<Response<Body>, Refusal> {
    let path = request.uri().path();
    let page = page::file(match (path, served.home) {
        ("/", Home::World) => "/world.html",
        _ => path,
    });
    // Styles and scripts are public and contain no data of the loop.
    if matches!(path, "/" | "/live") {
        served.gate.has_token(request.uri())?;
    }
    if request.method() != Method::GET {
        let text = "only GET is allowed\n";
        return Err(Refusal(StatusCode::METHOD_NOT_ALLOWED, text));
    }
    if let Some(file) = page {
        let mut response = Response::new(Body::from(file.bytes));
        let kind = HeaderValue::from_static(file.content_type);
        response.headers_mut().insert(header::CONTENT_TYPE, kind);
        return Ok(response);
    }
    if path != "/live" {
        return Err(Refusal(StatusCode::NOT_FOUND, "there is no such page\n"));
    }
    served.gate.origin(request.headers(), host)?;
    let Some(place) = ClientSlot::take(served) else {
        let text = "the limit of 64 clients is reached\n";
        return Err(Refusal(StatusCode::SERVICE_UNAVAILABLE, text));
    };
    let Some((response, socket)) = upgrade::upgrade(request) else {
        let text = "a WebSocket upgrade is required\n";
        return Err(Refusal(StatusCode::BAD_REQUEST, text));
    };
    tokio::spawn(async move {
        let served = &place.0;
        // The client may leave before the answer.
        if let Ok(socket) = socket.await {
            client::serve(socket, Arc::clone(&served.hub), served.commands.clone()).await;
        }
    });
    Ok(response)
}

/// One of the places for clients, until it is dropped.
struct ClientSlot(Arc<Served>);

impl ClientSlot {
    fn take(served: &Arc<Served>) -> Option<Self> {
        let one_more = |taken| (taken < MAX_CLIENTS).then_some(taken + 1);
        served
            .clients
            .fetch_update(Ordering::AcqRel, Ordering::Acquire, one_more)
            .ok()
            .map(|_| Self(Arc::clone(served)))
    }
}

impl Drop for ClientSlot {
    fn drop(&mut self) {
        self.0.clients.fetch_sub(1, Ordering::AcqRel);
    }
}
