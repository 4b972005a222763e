// AgonesSdk: speaks to the sidecar that Agones runs beside a game server, by its local HTTP
// interface (https://agones.dev/site/docs/guides/client-sdks/rest/).
#pragma once

#include "server/config/server_settings.h"
#include "shared/core/result.h"

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace zoned::app {

/// Where players reach this server, as the cluster has set it up.
struct AgonesAddress {
    std::string address;
    std::uint16_t tcp_port = 0;  ///< 0: the game server has no port of that name
    std::uint16_t udp_port = 0;
};

/// The part of a GameServer that matters here. Fails on anything that is none.
core::Result<AgonesAddress> parse_game_server(const std::string& json,
                                              const std::string& tcp_name,
                                              const std::string& udp_name);

class AgonesSdk {
  public:
    /// The port of the sidecar: AGONES_SDK_HTTP_PORT, else 9358. `tell` hears of failures that go
    /// on, on a thread of this class.
    AgonesSdk(const config::AgonesSettings& settings, std::function<void(const std::string&)> tell);
    AgonesSdk(const AgonesSdk&) = delete;
    AgonesSdk& operator=(const AgonesSdk&) = delete;
    ~AgonesSdk();

    /// Waits for the sidecar, which may start after the server, up to the settings' patience.
    core::Result<AgonesAddress> game_server();
    /// Players may come: tells so until the sidecar has heard it, and from then on passes signs of
    /// life on.
    void start();

    /// A sign of life; without one none is sent. From any thread.
    void alive() { alive_.store(true); }

    /// Ends the thread and has the cluster take the server away. At most a few seconds.
    void shutdown();

  private:
    bool post(const std::string& path, std::string& reason) const;
    void run();

    config::AgonesSettings settings_;
    std::function<void(const std::string&)> tell_;
    std::uint16_t port_ = 9358;
    std::atomic<bool> alive_{false};
    std::mutex mutex_;
    std::condition_variable wake_;
    bool stopping_ = false;
    std::thread thread_;
};

}  // namespace zoned::app
