// The part of the C interface for a WebSocket that the caller owns.
#include "client-sim/library/border.h"
#include "client-sim/library/caller_route.h"

#include <cstring>

namespace zoned::library {

namespace {

/// Why there is no route of the caller.
int no_route(const zoned_client* client) {
    return game_of(client) == nullptr ? without_game(client) : ZONED_CLIENT_BAD_ARGUMENT;
}

}  // namespace

// In a namespace g++ forgets that the header shows them.
#pragma GCC visibility push(default)

extern "C" {

int zoned_client_begin(zoned_client* client) {
    if (client == nullptr) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    return guarded(*client, [&]() -> int {
        auto route = std::make_unique<CallerRoute>();
        CallerRoute* const kept = route.get();
        if (!client->game->connect(std::move(route))) {
            return ZONED_CLIENT_NOT_READY;
        }
        client->caller = kept;
        return 0;
    });
}

int zoned_client_stream_wish(zoned_client* client) {
    CallerRoute* const route = caller_of(client);
    return route != nullptr ? static_cast<int>(route->take_wish()) : no_route(client);
}

int zoned_client_stream_opened(zoned_client* client) {
    CallerRoute* const route = caller_of(client);
    if (route == nullptr) {
        return no_route(client);
    }
    return guarded(*client, [&] {
        route->opened();
        return 0;
    });
}

int zoned_client_stream_frame(zoned_client* client, const void* frame, size_t size) {
    CallerRoute* const route = caller_of(client);
    if (route == nullptr) {
        return no_route(client);
    }
    if (frame == nullptr && size > 0) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    return guarded(*client, [&] {
        route->receive({static_cast<const std::uint8_t*>(frame), size});
        return 0;
    });
}

int zoned_client_stream_closed(zoned_client* client, const char* reason) {
    CallerRoute* const route = caller_of(client);
    if (route == nullptr) {
        return no_route(client);
    }
    return guarded(*client, [&] {
        route->closed(reason != nullptr ? reason : "");
        return 0;
    });
}

size_t zoned_client_next_frame(zoned_client* client, void* out, size_t capacity) {
    CallerRoute* const route = caller_of(client);
    const link::Bytes* const frame = route != nullptr ? route->frame() : nullptr;
    if (frame == nullptr) {
        return 0;
    }
    const std::size_t size = frame->size();
    if (out != nullptr && size <= capacity) {
        std::memcpy(out, frame->data(), size);
        route->drop_frame();
    }
    return size;
}

}  // extern "C"

#pragma GCC visibility pop

}  // namespace zoned::library
