// @GAME@-bots: client-sim with bots that play @GAME@; all its arguments but --behaviour.
#include "bots.h"

#include "client-sim/app/run.h"

#include <cstdio>

int main(int argc, char** argv) {
    const auto heard = std::make_shared<capture::Heard>();  // of the first bot: all hear the same
    const int exit_code =
        zoned::app::client_main(argc, argv, [&](std::size_t index, const std::string& team) {
            return std::make_unique<capture::Bot>(
                index, team, index == 0 ? heard : std::make_shared<capture::Heard>());
        });
    std::printf("flags taken %u, dropped %u, scored %u\nleaderboard:\n%s",
                heard->taken,
                heard->dropped,
                heard->scored,
                heard->leaderboard.c_str());
    return exit_code;
}
