// The part of the C interface that opens sockets.
#include "client-sim/library/border.h"
#include "client-sim/library/socket_route.h"

namespace zoned::library {

// In a namespace g++ forgets that the header shows them.
#pragma GCC visibility push(default)

extern "C" {

int zoned_client_connect(zoned_client* client, const char* host, uint16_t port) {
    if (client == nullptr || host == nullptr || host[0] == 0 || port == 0) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    return guarded(*client, [&]() -> int {
        auto route = std::make_unique<SocketRoute>(host, port, client->game->settings());
        return client->game->connect(std::move(route)) ? 0 : ZONED_CLIENT_NOT_READY;
    });
}

}  // extern "C"

#pragma GCC visibility pop

}  // namespace zoned::library
