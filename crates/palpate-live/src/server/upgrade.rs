//! Upgrade of a request to a WebSocket.

use hyper::body::Incoming;
use hyper::upgrade::Upgraded;
use hyper::{Request, Response};
use hyper_util::rt::TokioIo;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::handshake::server::create_response_with_body;
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};

use super::{Body, client};

/// A WebSocket on a connection that this server has accepted.
pub type WebSocket = WebSocketStream<TokioIo<Upgraded>>;

/// Returns the answer that upgrades `request` to a WebSocket, and the socket, which is ready once the answer is sent.
/// `None` if the request asks for no upgrade.
pub fn upgrade(
    mut request: Request<Incoming>,
) -> Option<(
    Response<Body>,
    impl Future<Output = hyper::Result<WebSocket>>,
)> {
    let response = create_response_with_body(&request, Body::default).ok()?;
    // A little more than a message may have, so that one a little too long is answered.
    let config = WebSocketConfig::default()
        .max_message_size(Some(2 * client::LONGEST))
        .max_frame_size(Some(2 * client::LONGEST));
    let upgraded = hyper::upgrade::on(&mut request);
    let socket = async move {
        let stream = TokioIo::new(upgraded.await?);
        Ok(WebSocketStream::from_raw_socket(stream, Role::Server, Some(config)).await)
    };
    Some((response, socket))
}
