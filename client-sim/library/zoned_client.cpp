// The session's half of the C interface: create, connect, poll, input, commands and events.
#include "client-sim/library/zoned_client.h"

#include "client-sim/library/border.h"
#include "client-sim/library/sized_struct.h"
#include "shared/core/elementary/elementary.h"
#include "shared/core/hex.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <numbers>

namespace zoned::library {

namespace {

constexpr std::size_t kPinBytes = 32;
constexpr char kOutOfMemory[] = "out of memory";

std::string text_of(const char* text) {
    return text != nullptr ? std::string(text) : std::string();
}

__attribute__((format(printf, 3, 4))) void say(char* error,
                                               std::size_t capacity,
                                               const char* format,
                                               ...) {
    if (error != nullptr && capacity > 0) {
        va_list arguments;
        va_start(arguments, format);
        std::vsnprintf(error, capacity, format, arguments);
        va_end(arguments);
    }
}

/// Empty: `out` is filled.
std::string read_trust(const zoned_client_settings& from, GameClientSettings& out) {
    using Kind = link::Trust::TrustKind;
    out.ca_file = text_of(from.ca_file);
    switch (from.trust) {
        case ZONED_CLIENT_TRUST_DEFAULT:
            return {};
        case ZONED_CLIENT_TRUST_ANYONE:
            out.trust = Kind::kInsecure;
            return {};
        case ZONED_CLIENT_TRUST_AUTHORITIES:
            out.trust = Kind::kVerify;
            return {};
        case ZONED_CLIENT_TRUST_PIN: {
            const auto pin = core::from_hex(text_of(from.pin));
            if (!pin || pin->size() != kPinBytes) {
                return "pin: wants 64 hex digits, the SHA-256 of the certificate";
            }
            out.trust = Kind::kPin;
            out.pin = *pin;
            return {};
        }
        default:
            return "trust: is none of zoned_client_trust";
    }
}

/// Empty: `out` is filled.
std::string read_sockets(const zoned_client_settings& from, GameClientSettings& out) {
    out.server_name = text_of(from.server_name);
    out.may_start_threads = from.no_threads != 1;
    if (from.sockets == nullptr) {
        return {};
    }
    zoned_client_sockets& sockets = out.sockets.emplace();
    if (!take(from.sockets, sockets) || sockets.open == nullptr || sockets.send == nullptr ||
        sockets.receive == nullptr || sockets.close == nullptr) {
        return "sockets: lacks its size or a function";
    }
    return {};
}

std::string read_settings(const zoned_client_settings& settings, GameClientSettings& out) {
    if (settings.view > ZONED_CLIENT_INTERPOLATE) {
        return "view: is none of zoned_client_view";
    }
    out.view = settings.view == ZONED_CLIENT_INTERPOLATE ? view::ViewKind::kInterpolate
                                                         : view::ViewKind::kExtrapolate;
    out.measure = settings.measure == 1;
    out.login.name = text_of(settings.name);
    out.login.team = text_of(settings.team);
    out.login.config_digest = text_of(settings.config_digest);
    out.login.world = text_of(settings.world);
    if (settings.ticket != nullptr) {
        out.login.ticket.assign(static_cast<const char*>(settings.ticket), settings.ticket_size);
    }
    const std::string wrong = read_sockets(settings, out);
    return wrong.empty() ? read_trust(settings, out) : wrong;
}

zoned_client_allocator system_allocator() {
    zoned_client_allocator out{};
    out.allocate = [](void* /*context*/, size_t size) {
        return std::malloc(size);
    };
    out.release = [](void* /*context*/, void* block) {
        std::free(block);
    };
    return out;
}

/// The allocator of the settings. False: it lacks something.
bool read_allocator(const zoned_client_settings& settings, zoned_client_allocator& out) {
    if (settings.allocator == nullptr) {
        out = system_allocator();
        return true;
    }
    return take(settings.allocator, out) && out.allocate != nullptr && out.release != nullptr;
}

/// Nothing of the client is left in the end.
void release(zoned_client* client) {
    (void)client->memory.run([client] { delete client->game; });
    const zoned_client_allocator allocator = client->memory.allocator();
    client->~zoned_client();
    allocator.release(allocator.context, client);
}

/// Radians to units of `turn` a full circle.
std::int64_t units_of(float angle, double turn) {
    constexpr double kCircle = 2.0 * std::numbers::pi;
    return std::llround(std::remainder(static_cast<double>(angle), kCircle) / kCircle * turn);
}

GameInput read_input(const zoned_client_input& from) {
    constexpr float kFull = 127.0F;
    constexpr std::int64_t kMostPitch = 16384;
    const float scale = kFull / std::max(1.0F, elementary::hypot(from.move_x, from.move_z));
    GameInput out;
    out.move_x = static_cast<std::int8_t>(std::lround(from.move_x * scale));
    out.move_z = static_cast<std::int8_t>(std::lround(from.move_z * scale));
    out.yaw = static_cast<std::uint16_t>(units_of(from.yaw, 65536.0));
    out.pitch = static_cast<std::int16_t>(
        std::clamp(units_of(from.pitch, 65536.0), -kMostPitch, kMostPitch));
    out.buttons = static_cast<std::uint16_t>(from.buttons);
    return out;
}

}  // namespace

// In a namespace g++ forgets that the header shows them.
#pragma GCC visibility push(default)

extern "C" {

uint32_t zoned_client_abi_version(void) {
    return ZONED_CLIENT_ABI;
}

zoned_client* zoned_client_create(uint32_t abi,
                                  const zoned_client_settings* settings,
                                  char* error,
                                  size_t error_capacity) {
    say(error, error_capacity, "%s", "");
    if (abi >> 16U != ZONED_CLIENT_ABI_MAJOR) {
        say(error,
            error_capacity,
            "this is version %u of the interface of libzoned_client, and the game was built for "
            "version %u; install the library that fits, or build anew",
            static_cast<unsigned>(ZONED_CLIENT_ABI_MAJOR),
            static_cast<unsigned>(abi >> 16U));
        return nullptr;
    }
    zoned_client_settings known;
    zoned_client_allocator allocator;
    if (!take(settings, known)) {
        say(error, error_capacity, "settings: is null, or has no size");
        return nullptr;
    }
    if (!read_allocator(known, allocator)) {
        say(error, error_capacity, "allocator: lacks its size or a function");
        return nullptr;
    }
    void* const memory = allocator.allocate(allocator.context, sizeof(zoned_client));
    if (memory == nullptr) {
        say(error, error_capacity, "%s", kOutOfMemory);
        return nullptr;
    }
    auto* const client = new (memory) zoned_client(allocator);
    const bool ended = client->memory.run([&] {
        GameClientSettings read;
        const std::string wrong = read_settings(known, read);
        if (wrong.empty()) {
            client->game = new GameClient(std::move(read));
        } else {
            say(error, error_capacity, "%s", wrong.c_str());
        }
    });
    if (!ended) {
        client->game = nullptr;
        say(error, error_capacity, "%s", kOutOfMemory);
    }
    if (client->game == nullptr) {
        release(client);
        return nullptr;
    }
    return client;
}

void zoned_client_destroy(zoned_client* client) {
    if (client != nullptr) {
        zoned_client_quit(client);
        release(client);
    }
}

void zoned_client_quit(zoned_client* client) {
    if (client != nullptr) {
        guarded(*client, [&] {
            client->game->quit();
            return 0;
        });
    }
}

int zoned_client_poll(zoned_client* client, double now_s) {
    if (client == nullptr) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    guarded(*client, [&] {
        client->game->poll(now_s);
        return 0;
    });
    return zoned_client_get_state(client);
}

int zoned_client_get_state(const zoned_client* client) {
    if (client == nullptr) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    switch (client->game != nullptr ? client->game->state() : link::SessionState::kClosed) {
        case link::SessionState::kIdle:
            return ZONED_CLIENT_IDLE;
        case link::SessionState::kConnecting:
            return ZONED_CLIENT_CONNECTING;
        case link::SessionState::kOnline:
            return ZONED_CLIENT_ONLINE;
        case link::SessionState::kWaiting:
            return ZONED_CLIENT_WAITING;
        case link::SessionState::kClosed:
            break;
    }
    return ZONED_CLIENT_CLOSED;
}

const char* zoned_client_trouble(const zoned_client* client) {
    if (client == nullptr) {
        return "there is no client";
    }
    return client->game != nullptr ? client->game->trouble().c_str() : kOutOfMemory;
}

int zoned_client_set_input(zoned_client* client, const zoned_client_input* input) {
    zoned_client_input read;
    if (client == nullptr || !take(input, read) || !std::isfinite(read.move_x) ||
        !std::isfinite(read.move_z) || !std::isfinite(read.yaw) || !std::isfinite(read.pitch)) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    if (client->game == nullptr) {
        return ZONED_CLIENT_FAILED;
    }
    client->game->set_input(read_input(read));
    return 0;
}

int zoned_client_command(zoned_client* client,
                         uint32_t kind,
                         const void* payload,
                         size_t payload_size) {
    if (client == nullptr || (payload == nullptr && payload_size > 0)) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    return guarded(*client, [&]() -> int {
        std::string bytes(static_cast<const char*>(payload), payload_size);
        return client->game->command(kind, std::move(bytes)) ? 0 : ZONED_CLIENT_NOT_READY;
    });
}

int zoned_client_next_event(zoned_client* client,
                            zoned_client_event* event,
                            void* payload,
                            size_t payload_capacity) {
    if (client == nullptr || event == nullptr || (payload == nullptr && payload_capacity > 0)) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    if (client->game == nullptr) {
        return ZONED_CLIENT_FAILED;
    }
    const wire::EventMessage* const next = client->game->event();
    if (next == nullptr) {
        return 0;
    }
    zoned_client_event out{};
    out.kind = next->kind;
    out.tick = next->tick;
    out.id = next->event_id;
    out.payload_size = next->payload.size();
    out.history = next->history ? 1 : 0;
    give_name(out.topic, next->topic);
    if (!give(event, out)) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    if (next->payload.size() > payload_capacity) {
        return ZONED_CLIENT_TOO_SMALL;
    }
    if (!next->payload.empty()) {
        std::memcpy(payload, next->payload.data(), next->payload.size());
    }
    client->game->drop_event();
    return 1;
}

}  // extern "C"

#pragma GCC visibility pop

}  // namespace zoned::library
