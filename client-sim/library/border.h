// Border: the client behind the C interface, and the wall that no lack of memory passes.
#pragma once

#include "client-sim/library/caller_route.h"
#include "client-sim/library/client_memory.h"
#include "client-sim/library/game_client.h"
#include "client-sim/library/zoned_client.h"

#include <string_view>

struct zoned_client {
    explicit zoned_client(const zoned_client_allocator& allocator) : memory(allocator) {}

    zoned::library::ClientMemory memory;
    zoned::library::GameClient* game = nullptr;     ///< nullptr: memory ran out
    zoned::library::CallerRoute* caller = nullptr;  ///< of the newest session that has one
};

namespace zoned::library {

/// nullptr where there is none, or none any more.
inline GameClient* game_of(const zoned_client* client) {
    return client != nullptr ? client->game : nullptr;
}

/// The result of a function that finds no game.
inline int without_game(const zoned_client* client) {
    return client == nullptr ? ZONED_CLIENT_BAD_ARGUMENT : ZONED_CLIENT_FAILED;
}

/// nullptr before a server has sent a world.
inline const view::View* view_of(const zoned_client* client) {
    const GameClient* const game = game_of(client);
    return game != nullptr ? game->view() : nullptr;
}

/// Why there is no view.
inline int no_view(const zoned_client* client) {
    return game_of(client) == nullptr ? without_game(client) : ZONED_CLIENT_NOT_READY;
}

/// nullptr where the caller carries no session.
inline CallerRoute* caller_of(zoned_client* client) {
    GameClient* const game = game_of(client);
    return game != nullptr && game->uses(client->caller) ? client->caller : nullptr;
}

/// The result of `work`, which may take memory, or `otherwise` where there is none left.
template <class Result, class Work>
Result guarded(const zoned_client& client, Result otherwise, Work&& work) noexcept {
    if (client.game == nullptr) {
        return otherwise;
    }
    // No client is const: zoned_client_create() makes them. One that is only looked at takes memory
    // for the answer.
    auto& changed = const_cast<zoned_client&>(client);
    Result result = otherwise;
    if (!changed.memory.run([&] { result = work(); })) {
        changed.game = nullptr;
        changed.caller = nullptr;
        return otherwise;
    }
    return result;
}

template <class Work>
int guarded(const zoned_client& client, Work&& work) noexcept {
    return guarded(client, static_cast<int>(ZONED_CLIENT_FAILED), std::forward<Work>(work));
}

/// A name with its closing 0, cut where it is too long.
inline void give_name(char (&out)[ZONED_CLIENT_NAME_BYTES], std::string_view name) {
    const std::size_t size = std::min(name.size(), sizeof(out) - 1);
    std::copy_n(name.begin(), size, out);
    out[size] = 0;
}

}  // namespace zoned::library
