// Live settings: what a config that is read anew changes in a running server, made ready to be
// taken as a whole.
#pragma once

#include "server/config/expand/reload_plan.h"
#include "server/mailbox/messages.h"
#include "server/session/session_settings.h"
#include "shared/core/result.h"

#include <asio/io_context.hpp>

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace zoned::app {

/// A plan with everything read that it needs: taking it cannot fail half-way.
struct PreparedReload {
    config::ReloadPlan plan;
    session::HostLimits limits;  ///< where plan.merged is set
};

/// The limits of the session host in these settings; reads the key files. Throws std::system_error
/// or std::runtime_error that names the file.
session::HostLimits host_limits_of(const config::Settings& settings);

/// Reads `file` with `sets` as for a start, and compares with what runs. Fails with all mistakes.
core::Result<PreparedReload> prepare_reload(const std::string& file,
                                            const std::vector<std::string>& sets,
                                            const config::Settings& running);

/// Changes one setting of what runs. Fails with the mistake, or where the setting takes a restart.
core::Result<PreparedReload> prepare_change(const std::string& path,
                                            const std::string& value,
                                            const config::Settings& running);

/// The settings of a running server, live changes included. A config is read on a thread of its
/// own: sockets are served meanwhile. All calls, and all answers, are on the network thread.
class LiveSettings {
  public:
    struct LivePorts {
        /// False: the loop has no room for them.
        std::function<bool(mailbox::NewBrains)> set_brains;
        std::function<void(const session::HostLimits&)> set_limits;
    };

    /// All changes, also those that wait for a restart; or why everything stays as it was.
    using Taken = core::Result<std::vector<config::SettingChange>>;
    using WhenTaken = std::function<void(const Taken&)>;

    /// `begun` outlives this.
    LiveSettings(asio::io_context& io, const config::Settings& begun, LivePorts ports);

    /// Takes all live changes of the file at once, between two ticks and two messages, or none.
    void reload(const std::string& file,
                const std::vector<std::string>& sets,
                const WhenTaken& done);
    /// Changes a setting for as long as the process lives.
    void change(const std::string& path, const std::string& value, const WhenTaken& done);
    /// Waits for what is being read; nobody is answered any more where the loop has ended.
    void finish();

  private:
    void read_aside(std::function<core::Result<PreparedReload>()> read, const WhenTaken& done);
    Taken take(const core::Result<PreparedReload>& prepared);

    asio::io_context& io_;
    std::shared_ptr<const config::Settings> current_;
    LivePorts ports_;
    std::thread reader_;
    bool reading_ = false;
};

/// "2 settings changed: a.b 1 -> 2, ...; 1 waits for a restart: c.d 3 -> 4".
[[nodiscard]] std::string text_of(const std::vector<config::SettingChange>& changes);

}  // namespace zoned::app
