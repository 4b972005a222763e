// ChangedWorld: a shipped world with random changes, each of which `zoned serve FILE --set CHANGE`
// takes.
#pragma once

#include "server/mailbox/messages.h"
#include "proto/config/config.pb.h"
#include "shared/core/result.h"
#include "shared/core/rng.h"

#include <string>
#include <vector>

namespace zoned::random_worlds {

struct ChangedWorld {
    std::string file;               ///< of the shipped world
    std::vector<std::string> sets;  ///< "path.to.field=value", in this order
    /// Come with a config that is read anew while it runs; empty: none is.
    std::vector<std::string> reload = {};
};

/// The command that runs it, and in words what is read anew.
std::string command_of(const ChangedWorld& world);

/// Draws changes by the schema alone, so that settings to come are changed too. Leaves out what
/// says how the process runs (ports, files, sessions, logs) and faults on purpose.
class WorldChanger {
  public:
    /// Throws std::runtime_error where a file is no config.
    explicit WorldChanger(std::vector<std::string> files);

    /// A world that `zoned check` accepts, with at most `most_changes` changes: numbers anywhere in
    /// their ranges, other choices and names, parts that are cleared, added, or taken from the
    /// other worlds. Standard error gets each world before it is checked.
    [[nodiscard]] ChangedWorld draw(core::Rng& rng, int most_changes) const;

    /// Gives a world changes of its agents that a running server takes; it may find none.
    void draw_reload(core::Rng& rng, int most_changes, ChangedWorld& world) const;

  private:
    struct ShippedWorld {
        std::string file;
        proto::config::Config config;
    };

    /// The sets of one change; empty: none was found at the place that was drawn.
    [[nodiscard]] std::vector<std::string> draw_change(const proto::config::Config& config,
                                                       core::Rng& rng) const;
    [[nodiscard]] std::vector<std::string> draw_guest(const proto::config::Config& config,
                                                      core::Rng& rng) const;

    std::vector<ShippedWorld> worlds_;
};

/// Whether `zoned check` would accept it.
bool is_accepted(const ChangedWorld& world);

/// The agents that a running server takes when it reads the changes anew. Fails where it refuses
/// them, and where they change no agents.
core::Result<mailbox::NewBrains> brains_of_reload(const ChangedWorld& world);

}  // namespace zoned::random_worlds
