// Device list: finds the OpenCL devices, chooses one and gives the reason.
#pragma once

#include "shared/core/result.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::compute {

enum class DeviceKind : std::uint8_t {
    kCpu,
    kGpu,
    kOther
};

std::string_view name_of(DeviceKind kind);  ///< "cpu", "gpu", "other"

struct DeviceInfo {
    std::string name;
    std::string platform;
    std::string driver;  ///< version of the driver
    DeviceKind kind = DeviceKind::kOther;
    unsigned compute_units = 0;
    std::uint64_t memory_bytes = 0;
    std::uint64_t largest_buffer_bytes = 0;
    std::size_t largest_group = 1;   ///< work items of a work group
    std::size_t local_bytes = 0;     ///< local memory of a work group
    bool own_local_memory = false;   ///< it is fast memory of its own, not a part of the common one
    bool host_memory = false;        ///< works in the host's memory: mapping copies nothing
    bool correctly_rounded = false;  ///< division and square root, which equal results need
    bool available = true;           ///< and it has a compiler
    void* handle = nullptr;          ///< cl_device_id
    void* platform_handle = nullptr;
};

/// All devices of all platforms, in OpenCL's order. Loads libOpenCL. Fails where there is no
/// library or no platform, with the reason; no devices is an empty list.
core::Result<std::vector<DeviceInfo>> list_devices();

struct DeviceChoice {
    std::optional<std::size_t> index;  ///< into the list; nothing: the CPU path does it all
    std::string reason;                ///< one line that says why this one, or why none
};

/// `wish` is "" or "auto", "cpu", "gpu", "none", or part of a device's name (case does not matter).
/// Devices that are not available or do not round correctly are never taken. "auto" prefers a GPU
/// to a CPU, then more compute units to fewer, then the first of equals.
DeviceChoice choose_device(std::span<const DeviceInfo> devices, std::string_view wish);

/// "gpu NAME (PLATFORM, driver V), 24 compute units, 8192 MiB".
std::string to_text(const DeviceInfo& device);

}  // namespace zoned::compute
