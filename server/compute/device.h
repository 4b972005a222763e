// Device: an open OpenCL device with its queue and programs, and its handling of failures.
#pragma once

#include "server/compute/device_list.h"
#include "server/compute/kernel_source.h"
#include "server/compute/program_cache.h"
#include "shared/core/result.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

namespace zoned::compute {

struct Done {};

/// Done, or the reason why not.
using Status = core::Result<Done>;

/// Faults on purpose, for tests and drills. The device reads them at each call.
struct DeviceFaults {
    int launches = -1;       ///< so many launches succeed, the next fails; -1: none fails
    double share_run = 0.0;  ///< 0..1: of the failing launch's work groups that run all the same
    int calls = -1;  ///< so many calls that queue, wait or set arguments succeed, the next fails
    bool refuse_binaries = false;         ///< programs from the cache fail to build
    std::size_t memory_bytes = SIZE_MAX;  ///< buffers may take as much in all
};

/// How buffers reach the device.
enum class BufferMode : std::uint8_t {
    kAuto,    ///< mapped on a CPU, which works in the host's memory, else copied
    kMapped,  ///< the device works on the host's columns; nothing is copied
    kCopied   ///< transfers, queued with the kernels and waited for once
};

struct DeviceSettings {
    std::string wish;          ///< see choose_device
    std::string cache_folder;  ///< of built programs; empty: none is kept
    BufferMode buffers = BufferMode::kAuto;
    FindKernelFile kernels;  ///< other kernels than those in the program; null: those
    const DeviceFaults* testing = nullptr;
};

/// How programs came about so far.
struct ProgramCounts {
    unsigned built = 0;   ///< from source
    unsigned loaded = 0;  ///< from the cache
    unsigned stored = 0;  ///< into the cache
};

/// All kernels are built without fast-math, with correctly rounded division and square root, and
/// without contraction.
///
/// A device that failed once is lost: every later call fails at once with the first reason, and its
/// user goes on without it. A kernel that does not build is lost alone.
///
/// Threads take turns: a thread that queues work holds turn() until the work is finished. Kernels
/// and buffers may go at any time.
class Device {
  public:
    /// Chooses among the devices and opens one. Fails with the reason where none fits or opens:
    /// then the CPU path does the work.
    static core::Result<std::unique_ptr<Device>> open(const DeviceSettings& settings);

    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    [[nodiscard]] const DeviceInfo& info() const;
    [[nodiscard]] const std::string& reason() const;  ///< why this one
    [[nodiscard]] BufferMode buffers() const;         ///< kMapped or kCopied

    [[nodiscard]] bool lost() const;
    [[nodiscard]] const std::string& fault() const;  ///< why it was lost; empty: it was not

    [[nodiscard]] std::mutex& turn();

    /// Waits for all that was queued.
    Status finish();

    [[nodiscard]] ProgramCounts programs() const;

  private:
    friend class Kernel;
    friend class Buffer;
    struct Impl;

    explicit Device(std::unique_ptr<Impl> impl);

    Status lose(std::string why);

    std::unique_ptr<Impl> impl_;
};

/// A kernel of a device, which must outlive it.
class Kernel {
  public:
    /// Builds "kernels/NAME.cl" with options such as "-DZK_AIR=1", or takes it from the cache. A
    /// build error holds the compiler's log, which names file and line in kernels/.
    static core::Result<Kernel> make(Device& device,
                                     std::string_view file,
                                     const std::string& function,
                                     const std::string& options);

    Kernel(Kernel&& other) noexcept;
    Kernel& operator=(Kernel&& other) noexcept;
    ~Kernel();

    /// By value; T must have the layout of the kernel's parameter.
    template <class T>
    Status set(unsigned index, const T& value) {
        return set_bytes(index, &value, sizeof(value));
    }

    Status set(unsigned index, const class Buffer& buffer);

    /// Bytes of local memory.
    Status set_local(unsigned index, std::size_t bytes);

    /// Queues work items 0 .. count - 1, and more until the last work group is full. Needs count >
    /// 0. The group's size is group().
    Status launch(std::size_t count);

    [[nodiscard]] std::size_t group() const { return group_; }

    /// Another size than the one chosen; it is cut to what the kernel can have.
    void set_group(std::size_t items);

    [[nodiscard]] std::size_t groups_of(std::size_t count) const {
        return (count + group_ - 1) / group_;
    }

  private:
    Kernel() = default;
    Status set_bytes(unsigned index, const void* value, std::size_t bytes);
    Status launch_groups(std::size_t groups);

    Device* device_ = nullptr;
    void* handle_ = nullptr;
    std::size_t group_ = 1;
    std::size_t largest_group_ = 1;
};

/// Work items of a group for a kernel on a device. A CPU runs a group as one loop: large groups
/// cost less per item, and 1,024 still leave a thread many to take. A GPU wants a few times its
/// width. `limit` and `multiple` are the kernel's.
std::size_t choose_group(const DeviceInfo& device, std::size_t limit, std::size_t multiple);

/// Memory of the host that a device works on or gets copies of.
class Buffer {
  public:
    /// `host` is `bytes` long, begins on a page (see HostBlock) and outlives the buffer. Fails
    /// where the device has not got the memory, which loses nothing.
    static core::Result<Buffer> over(Device& device, void* host, std::size_t bytes);

    Buffer(Buffer&& other) noexcept;
    Buffer& operator=(Buffer&& other) noexcept;
    ~Buffer();

    /// The part of a buffer that changes hands: rows of `bytes`, the first at the buffer's begin,
    /// `pitch` >= bytes from one begin to the next. They go as one transfer.
    struct Rows {
        std::size_t bytes = 0;
        std::size_t pitch = 0;
        std::size_t count = 0;
    };

    /// A buffer begins with the host. The device gets the rows; the host must not touch the buffer
    /// until it took it back. A mapped buffer changes hands as a whole.
    Status give(const Rows& rows);
    /// Queues the transfer back; then Device::finish(), then settle(). No bytes: nothing was
    /// changed.
    Status take(const Rows& rows);

    Status give() { return give(whole()); }

    Status take() { return take(whole()); }

    /// The host's memory holds the returned data. Where the device was lost before, copied memory
    /// holds its content at give(), and mapped memory the kernels' results until then.
    void settle();

    [[nodiscard]] std::size_t bytes() const { return bytes_; }

  private:
    friend class Kernel;

    Buffer() = default;
    int make_staging();
    Status map();
    Status unmap();
    template <class Copy>
    int transfer(Copy copy, const Rows& rows);
    template <class Visit>
    static void for_each_row(const Rows& rows, Visit&& visit);

    [[nodiscard]] Rows whole() const { return {bytes_, bytes_, 1}; }

    Device* device_ = nullptr;
    void* handle_ = nullptr;
    void* host_ = nullptr;
    void* staging_handle_ = nullptr;
    void* staging_ = nullptr;  ///< all copies pass through it; half of one does no harm
    std::size_t bytes_ = 0;
    Rows coming_;          ///< being transferred back
    bool mapped_ = false;  ///< the host may touch it
};

}  // namespace zoned::compute
