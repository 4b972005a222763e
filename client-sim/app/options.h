// Options: the command line of client-sim as a checked structure.
#pragma once

#include "client-sim/app/swarm.h"
#include "client-sim/link/conditioner.h"

#include <optional>
#include <string>
#include <vector>

namespace zoned::app {

struct Options {
    std::string host;
    std::string port;
    SwarmSettings swarm;
    link::ConditionerSettings conditioner;
    std::vector<std::uint8_t> pin;
    bool insecure_dev = false;
    std::string ca_file;
    std::string report_file;
    int udp_sockets = 16;
    bool websocket = false;
    bool quiet = false;
};

/// Exit codes of the command line's contract.
enum ClientExitCode : int {
    kGood = 0,
    kInconsistent = 1,
    kBadUsage = 2,
    kEnvironment = 3
};

/// Parses and checks. Without a value the program ends with `exit_code` (0 after --help), and the
/// mistake has been printed.
std::optional<Options> parse_options(int argc, char** argv, int& exit_code);

}  // namespace zoned::app
