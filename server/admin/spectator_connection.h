// SpectatorConnection: one viewer's WebSocket; what it does not take in time is dropped.
#pragma once

#include "server/admin/admin_router.h"
#include "server/admin/admin_stream.h"
#include "server/admin/spectator/spectator_hub.h"

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket/stream.hpp>

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>

namespace zoned::admin {

/// So many messages may wait for a viewer; with more it skips to the newest state.
inline constexpr std::size_t kMostQueuedMessages = 8;

class SpectatorConnection : public std::enable_shared_from_this<SpectatorConnection> {
  public:
    using UpgradeRequest = boost::beast::http::request<boost::beast::http::string_body>;

    SpectatorConnection(AdminStream stream,
                        std::uint64_t number,
                        AdminRouter& router,
                        std::function<void(std::uint64_t number)> closed);

    /// Answers the request and sends `scene`; messages follow once the handshake is done.
    void accept(const UpgradeRequest& request, std::string scene);

    /// Sends what changed; or everything, to a viewer that misses something.
    void send(const SpectatorMessage& change, const std::function<SpectatorMessage()>& everything);

    /// Sends a layer that this viewer asked for; drops it where messages wait already.
    void send_layer(SpectatorLayer layer, const SpectatorMessage& message);

    /// Whether the viewer has said what it looks at, and that: see SpectatorConnection::on_wish.
    [[nodiscard]] bool has_wish() const { return has_wish_; }

    [[nodiscard]] const SpectatorWish& wish() const { return wish_; }

    /// Closes at once.
    void abort();

  private:
    struct Queued {
        SpectatorMessage bytes;
        bool text = false;
    };

    void read();
    /// 16 bytes, little-endian: u32 layers, f32 x, y, z of the eye; others are counted and ignored.
    void on_wish();
    void push(Queued message);
    void write();
    void finish();

    std::uint64_t number_;
    AdminRouter& router_;
    std::function<void(std::uint64_t)> closed_callback_;
    boost::beast::websocket::stream<AdminStream, false> socket_;  // messages are not compressed
    boost::beast::flat_buffer buffer_;
    std::deque<Queued> queue_;
    SpectatorWish wish_;
    bool has_wish_ = false;
    bool open_ = false;
    bool needs_everything_ = true;
    bool closed_ = false;
};

}  // namespace zoned::admin
