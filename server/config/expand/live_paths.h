// live_paths: the settings of the server process that may change while it runs, and how to take
// them out of a config or from another one.
#pragma once

#include <array>
#include <string_view>

namespace google::protobuf {
class Message;
}

namespace zoned::config {

/// Fields of messages that the config holds once.
inline constexpr std::array<std::string_view, 15> kLivePaths{
    "network.max_clients",
    "network.max_load",
    "network.max_sessions_per_address",
    "network.silence_timeout_s",
    "session.grace_s",
    "session.login_timeout_s",
    "session.max_per_account",
    "session.max_commands_per_s",
    "session.max_datagrams_per_s",
    "session.max_unacked_events",
    "session.dev_mode_loopback",
    "session.dev_rights",
    "session.ticket_public_key_file",
    "run.log_level",
    "log.level",
};

/// Top-level fields that hold nothing but agents' settings, or the script of the rules: these
/// change together, between two ticks.
inline constexpr std::array<std::string_view, 9> kBrainFields{"brain",
                                                              "tree",
                                                              "domain",
                                                              "fuzzy",
                                                              "blend",
                                                              "behaviour",
                                                              "difficulty",
                                                              "ai",
                                                              "script"};
/// The same of a type.
inline constexpr std::array<std::string_view, 3> kTypeBrainFields{"brain",
                                                                  "perception",
                                                                  "behaviour"};

/// Makes the field what it is in `from`, or unset where that is null.
void take_setting(std::string_view path,
                  const google::protobuf::Message* from,
                  google::protobuf::Message& to);

}  // namespace zoned::config
