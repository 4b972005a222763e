// Device::Impl: the handles of an open device, shared by the sources that work with them.
#pragma once

#include "server/compute/device.h"
#include "server/compute/opencl_api.h"

#include <atomic>
#include <map>
#include <utility>

namespace zoned::compute {

struct Device::Impl {
    const OpenClApi* cl = nullptr;
    DeviceInfo info;
    std::string reason;
    BufferMode buffers = BufferMode::kMapped;
    FindKernelFile kernels;
    const DeviceFaults* testing = nullptr;
    ProgramCache cache;
    ProgramCounts counts;
    std::string fault;
    std::mutex turn;
    cl_context context = nullptr;
    cl_command_queue queue = nullptr;
    std::atomic<std::size_t> memory_bytes{0};  ///< of all buffers, which go without a turn
    int launches = 0;
    int calls = 0;
    using ProgramName = std::pair<std::string, std::string>;  ///< file and options
    std::map<ProgramName, cl_program> programs;
    std::map<ProgramName, std::string> broken;  ///< why; they are not built again

    [[nodiscard]] cl_device_id device() const { return static_cast<cl_device_id>(info.handle); }

    /// The answer of a call of the driver, or the fault that a test wants in its place.
    template <class Call>
    cl_int call(const Call& driver) {
        const bool fails = testing != nullptr && testing->calls >= 0 && calls >= testing->calls;
        ++calls;
        return fails ? CL_OUT_OF_RESOURCES : driver();
    }

    /// From the cache, or from source.
    core::Result<cl_program> program(std::string_view file, const std::string& options);

  private:
    core::Result<cl_program> build(std::string_view file,
                                   const std::string& source,
                                   const std::string& options) const;
    [[nodiscard]] cl_program load(const ProgramKey& key) const;
    void store(const ProgramKey& key, cl_program program);
};

inline Status done() {
    return Done{};
}

}  // namespace zoned::compute
