// Supervision: tells those who look after the process, systemd and Agones, that it is ready, that
// its world ticks, and that it ends.
#pragma once

#include "server/app/supervision/agones_sdk.h"
#include "server/app/supervision/service_notice.h"
#include "server/config/server_settings.h"

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>

#include <functional>
#include <memory>
#include <string>

namespace zoned::app {

class Supervision {
  public:
    /// `turns`: how many the tick loop has made, called on the thread of `io`. A world that a
    /// developer has paused makes turns too.
    Supervision(asio::io_context& io,
                const config::ServerSettings& settings,
                std::function<std::uint64_t()> turns);

    /// Where players reach this server; a port of 0 is the one that it listens at. Waits for Agones
    /// where it is asked for; throws std::runtime_error when it does not answer.
    [[nodiscard]] config::AdvertiseSettings find_address();
    /// From here on signs of life go out as long as the world ticks. `text`: one line.
    void ready(const std::string& text);
    void stopping(const std::string& why);
    /// The last word, when sockets are closed.
    void stopped();

  private:
    void arm();
    void look();

    config::ServerSettings settings_;
    std::function<std::uint64_t()> turns_;
    ServiceNotice notice_;
    std::unique_ptr<AgonesSdk> agones_;
    asio::steady_timer timer_;
    double period_s_ = 0.0;  ///< 0: nobody asks for signs of life
    std::uint64_t last_turns_ = 0;
    bool stuck_ = false;
    bool ended_ = false;
};

}  // namespace zoned::app
