// Border: the client behind the C interface, and the wall that no exception passes.
#pragma once

#include "client-sim/library/caller_route.h"
#include "client-sim/library/game_client.h"
#include "client-sim/library/zoned_client.h"

#include <exception>
#include <utility>

struct zoned_client {
    explicit zoned_client(zoned::library::GameClientSettings settings)
        : game(std::move(settings)) {}

    zoned::library::GameClient game;
    zoned::library::CallerRoute* caller = nullptr;  ///< of the newest session that has one
};

namespace zoned::library {

/// nullptr where the caller carries no session.
inline CallerRoute* caller_of(zoned_client* client) {
    return client != nullptr && client->game.uses(client->caller) ? client->caller : nullptr;
}

#if defined(__cpp_exceptions)

/// The result of `work`, or `otherwise` when it throws: memory ran out.
template <class Result, class Work>
Result guarded(Result otherwise, Work&& work) noexcept {
    try {
        return work();
    } catch (...) {
        return otherwise;
    }
}

/// The same for calls that change the client: it ends, and says why.
template <class Work>
int guarded(zoned_client& client, Work&& work) noexcept {
    try {
        return work();
    } catch (const std::exception& error) {
        return guarded(static_cast<int>(ZONED_CLIENT_FAILED), [&] {
            client.game.fail(error.what());
            return static_cast<int>(ZONED_CLIENT_FAILED);
        });
    } catch (...) {
        return ZONED_CLIENT_FAILED;
    }
}

#else

// In WebAssembly a lack of memory stops the module: its page sees a trap.
template <class Result, class Work>
Result guarded(Result /*otherwise*/, Work&& work) noexcept {
    return work();
}

template <class Work>
int guarded(zoned_client& /*client*/, Work&& work) noexcept {
    return work();
}

#endif

/// A name with its closing 0, cut where it is too long.
inline void give_name(char (&out)[ZONED_CLIENT_NAME_BYTES], const std::string& name) {
    const std::size_t size = std::min(name.size(), sizeof(out) - 1);
    std::copy_n(name.begin(), size, out);
    out[size] = 0;
}

}  // namespace zoned::library
