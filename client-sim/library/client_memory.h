// ClientMemory: all memory of one client, from the allocator of its game.
#pragma once

#include "client-sim/library/zoned_client.h"
#include "shared/core/foreign_handle.h"

#include <array>
#include <cstddef>

namespace zoned::library {

/// The library's operators new and delete take from the memory of the client whose call runs on
/// this thread. They are the library's alone: its version script exports none. Where the allocator
/// gives nothing the call ends at once, by a jump: nothing of the client runs again, and all of its
/// blocks and handles are given back without a destructor. So no code needs a way for it, and no
/// frame a table to unwind it.
class ClientMemory {
  public:
    explicit ClientMemory(const zoned_client_allocator& allocator) : allocator_(allocator) {}

    ~ClientMemory() { give_back(); }

    ClientMemory(const ClientMemory&) = delete;
    ClientMemory& operator=(const ClientMemory&) = delete;

    /// False: memory ran out in the middle. All is given back, and must not be touched again.
    template <class Work>
    bool run(Work&& work) noexcept {
        return run([](void* called) { (*static_cast<Work*>(called))(); }, &work);
    }

    /// Aligned to 16 bytes. nullptr: the allocator gives nothing.
    [[nodiscard]] void* take(std::size_t size) noexcept;
    /// A block of any client, or of none.
    static void give(void* block) noexcept;

    /// For operator new: of the client whose call runs. Does not return where there is none.
    [[nodiscard]] static void* take_current(std::size_t size) noexcept;
    /// The same, but nullptr where there is none.
    [[nodiscard]] static void* try_current(std::size_t size) noexcept;

    [[nodiscard]] const zoned_client_allocator& allocator() const { return allocator_; }

    /// All handles and blocks.
    void give_back() noexcept;

  private:
    /// Before each block that the library uses.
    struct Header {
        ClientMemory* owner = nullptr;  // nullptr: of no client
        std::size_t size_class = 0;
    };

    /// Before each block of the caller's allocator.
    struct Link {
        Link** to_this = nullptr;
        Link* next = nullptr;
    };

    /// A block that waits for its next use.
    struct Free {
        Free* next = nullptr;
    };

    // Blocks have sizes 32, 64 ... 65536 with their headers, and are kept for their next use: few
    // sizes, so that a frame soon finds all that it wants. Small ones are cut from slabs; larger
    // ones than all of these are given back at once.
    static constexpr std::size_t kClasses = 12;
    static constexpr std::size_t kSmallest = 32;
    static constexpr std::size_t kMostCut = 2048;
    static constexpr std::size_t kSlabBytes = 4096;

    __attribute__((noinline)) bool run(void (*work)(void*), void* argument) noexcept;
    void leave() noexcept;
    [[nodiscard]] void* take_link(std::size_t size) noexcept;
    [[nodiscard]] void* cut(std::size_t size) noexcept;

    zoned_client_allocator allocator_;
    Link* links_ = nullptr;
    std::array<Free*, kClasses> free_{};
    std::byte* slab_ = nullptr;
    std::size_t slab_left_ = 0;
    core::ForeignHandles handles_;
    ClientMemory* before_ = nullptr;  // whose call this one interrupts
    core::ForeignHandles* listed_before_ = nullptr;
    void* escape_ = nullptr;  // out of the call that runs
};

}  // namespace zoned::library
