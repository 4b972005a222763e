// WebSocketStream: frames as messages of a WebSocket: without TLS on this machine, else with it.
#pragma once

#include "client-sim/link/frame_stream.h"

namespace zoned::link {

/// A stream that speaks to the server's WebSocket port as a browser does.
[[nodiscard]] std::shared_ptr<FrameStream> make_websocket_stream(asio::io_context& io,
                                                                 asio::ssl::context& tls,
                                                                 const Trust& trust,
                                                                 StreamEvents events);

}  // namespace zoned::link
