#include "tests/harness/side_effects.h"

#include "server/config/settings.h"
#include "server/zone/faults/decorated_rules.h"
#include "tests/harness/virtual_server.h"

#include <dlfcn.h>
#include <pthread.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/types.h>

#include <algorithm>
#include <atomic>
#include <cstdarg>
#include <cstdio>
#include <ctime>
#include <memory>
#include <utility>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define ZONED_REPLACES_LIBC 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define ZONED_REPLACES_LIBC 0
#endif
#endif
#ifndef ZONED_REPLACES_LIBC
#define ZONED_REPLACES_LIBC 1
#endif

namespace zoned::harness {

namespace {

/// The watched call that runs on a thread.
struct Watched {
    SideEffects* effects = nullptr;  // null: none runs
    const char* callback = "";
    int depth = 0;  // rules may be called within a call
};

thread_local Watched watched;

class WatchedRules final : public zone::DecoratedRules {
  public:
    WatchedRules(std::unique_ptr<zone::Rules> rules, SideEffects& effects)
        : DecoratedRules(std::move(rules)),
          effects_(effects) {}

  private:
    void enter(const char* call) const override {
        if (watched.depth++ == 0) {
            watched.effects = &effects_;
            watched.callback = call;
        }
    }

    void leave() const override {
        if (--watched.depth == 0) {
            watched.effects = nullptr;
        }
    }

    SideEffects& effects_;
};

/// Called by the replaced functions before they pass the call on: under sanitizers there are none.
[[maybe_unused]] void note_call(const char* what, const char* function, const char* of = "") {
    SideEffects* const effects = std::exchange(watched.effects, nullptr);  // noting calls some, too
    if (effects != nullptr) {
        effects->note({what, function, watched.callback, of != nullptr ? of : ""});
        watched.effects = effects;
    }
}

}  // namespace

bool SideEffects::work() {
    return ZONED_REPLACES_LIBC != 0;
}

void SideEffects::watch(VirtualServer& server) {
    if (!server.settings().script) {
        server.wrap_rules([this](std::unique_ptr<zone::Rules> rules) {
            return std::make_unique<WatchedRules>(std::move(rules), *this);
        });
    }
}

void SideEffects::note(SideEffect effect) {
    const std::lock_guard lock(guard_);
    if (std::find(found_.begin(), found_.end(), effect) == found_.end()) {
        found_.push_back(std::move(effect));
    }
}

std::vector<SideEffect> SideEffects::found() const {
    const std::lock_guard lock(guard_);
    return found_;
}

std::string SideEffects::text() const {
    std::string text;
    for (const SideEffect& effect : found()) {
        text += (text.empty() ? "" : "; ") + effect.callback + " calls " + effect.function +
                (effect.of.empty() ? "" : " ('" + effect.of + "')") + ", " + effect.what;
    }
    return text;
}

}  // namespace zoned::harness

#if ZONED_REPLACES_LIBC

// Below: functions of libc that come before libc's own in this program. Each finds the next one of
// its name.

namespace {

using zoned::harness::note_call;

constexpr const char* kClock = "a clock";
constexpr const char* kFile = "a file";
constexpr const char* kRandom = "a random number";
constexpr const char* kSocket = "a socket";
constexpr const char* kEnvironment = "the environment";
constexpr const char* kThread = "a thread";

template <class Function>
Function* next(std::atomic<Function*>& found, const char* name) {
    Function* function = found.load(std::memory_order_relaxed);
    if (function == nullptr) {
        function = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
        found.store(function, std::memory_order_relaxed);
    }
    return function;
}

/// The mode of open(), which is there where the flags may create a file.
#define ZONED_MODE_OF(flags)                                     \
    mode_t mode = 0;                                             \
    if (((flags)&0100) != 0 || ((flags)&020000000) != 0) {       \
        va_list arguments;                                       \
        va_start(arguments, flags);                              \
        mode = static_cast<mode_t>(va_arg(arguments, unsigned)); \
        va_end(arguments);                                       \
    }

/// `result name(parameters)`, passed on with `arguments`.
#define ZONED_REPLACE(what, of, result, name, parameters, arguments) \
    result name parameters {                                         \
        using Function = result parameters;                          \
        static std::atomic<Function*> found = nullptr;               \
        note_call(what, #name, of);                                  \
        return next<Function>(found, #name) arguments;               \
    }

#define ZONED_REPLACE_OPEN(name)                                \
    int name(const char* path, int flags, ...) {                \
        using Function = int(const char*, int, ...);            \
        static std::atomic<Function*> found = nullptr;          \
        ZONED_MODE_OF(flags)                                    \
        note_call(kFile, #name, path);                          \
        return next<Function>(found, #name)(path, flags, mode); \
    }

#define ZONED_REPLACE_OPENAT(name)                                      \
    int name(int folder, const char* path, int flags, ...) {            \
        using Function = int(int, const char*, int, ...);               \
        static std::atomic<Function*> found = nullptr;                  \
        ZONED_MODE_OF(flags)                                            \
        note_call(kFile, #name, path);                                  \
        return next<Function>(found, #name)(folder, path, flags, mode); \
    }

}  // namespace

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wredundant-decls"
extern "C" {

ZONED_REPLACE(kClock, "", time_t, time, (time_t * out) noexcept, (out))
ZONED_REPLACE(kClock, "", clock_t, clock, () noexcept, ())
ZONED_REPLACE(kClock, "", int, clock_gettime, (clockid_t id, timespec* out) noexcept, (id, out))
ZONED_REPLACE(kClock, "", int, gettimeofday, (timeval * out, void* zone) noexcept, (out, zone))
ZONED_REPLACE(kClock, "", int, nanosleep, (const timespec* length, timespec* left), (length, left))
ZONED_REPLACE_OPEN(open)
ZONED_REPLACE_OPEN(open64)
ZONED_REPLACE_OPENAT(openat)
ZONED_REPLACE_OPENAT(openat64)
ZONED_REPLACE(kFile, path, FILE*, fopen, (const char* path, const char* mode), (path, mode))
ZONED_REPLACE(kFile, path, FILE*, fopen64, (const char* path, const char* mode), (path, mode))
ZONED_REPLACE(kRandom,
              "",
              ssize_t,
              getrandom,
              (void* out, size_t bytes, unsigned flags),
              (out, bytes, flags))
ZONED_REPLACE(kRandom, "", int, getentropy, (void* out, size_t bytes), (out, bytes))
ZONED_REPLACE(kRandom, "", int, rand, () noexcept, ())
ZONED_REPLACE(kRandom, "", long, random, () noexcept, ())
ZONED_REPLACE(kRandom, "", double, drand48, () noexcept, ())
ZONED_REPLACE(kSocket,
              "",
              int,
              socket,
              (int domain, int type, int protocol) noexcept,
              (domain, type, protocol))
ZONED_REPLACE(kSocket,
              "",
              int,
              socketpair,
              (int domain, int type, int protocol, int* pair) noexcept,
              (domain, type, protocol, pair))
ZONED_REPLACE(kEnvironment, name, char*, getenv, (const char* name) noexcept, (name))
ZONED_REPLACE(
    kThread,
    "",
    int,
    pthread_create,
    (pthread_t * thread, const pthread_attr_t* as, void* (*start)(void*), void* argument) noexcept,
    (thread, as, start, argument))

/// std::random_device::_M_getval(): it asks the processor, which no function of libc sees.
unsigned _ZNSt13random_device9_M_getvalEv(void* device) {
    using Function = unsigned(void*);
    static std::atomic<Function*> found = nullptr;
    note_call(kRandom, "std::random_device");
    return next<Function>(found, "_ZNSt13random_device9_M_getvalEv")(device);
}

}  // extern "C"
#pragma GCC diagnostic pop

#endif  // ZONED_REPLACES_LIBC
