#include "server/compute/opencl_api.h"

#include <dlfcn.h>
#include <sched.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <utility>

namespace zoned::compute {

namespace {

std::atomic<bool> asked_for_opencl{false};

/// PoCL's threads are left where they wake up, and on two cores both woke on the same one: a
/// million particles took as long as on one thread. With this variable it keeps thread i on CPU i.
/// CPU i has to be ours, so it is set only where all are. The environment's own setting goes
/// before.
void keep_pocl_threads_apart() {
    cpu_set_t ours;
    CPU_ZERO(&ours);
    if (sched_getaffinity(0, sizeof(ours), &ours) == 0 &&
        CPU_COUNT(&ours) == sysconf(_SC_NPROCESSORS_CONF)) {
        setenv("POCL_AFFINITY", "1", 0);
    }
}

/// The library stays open: drivers do not survive being unloaded.
core::Result<OpenClApi> open_opencl() {
    using Opened = core::Result<OpenClApi>;
    keep_pocl_threads_apart();
    void* const library = dlopen("libOpenCL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) {
        const char* const reason = dlerror();
        return Opened::failure(std::string("OpenCL: ") +
                               (reason != nullptr ? reason : "no reason"));
    }
    OpenClApi api;
#define ZONED_OPENCL_LOOK_UP(name)                                               \
    api.name = reinterpret_cast<decltype(&::name)>(dlsym(library, #name));       \
    if (api.name == nullptr) {                                                   \
        return Opened::failure("OpenCL: libOpenCL.so.1 has no function " #name); \
    }
    ZONED_OPENCL_FUNCTIONS(ZONED_OPENCL_LOOK_UP)
#undef ZONED_OPENCL_LOOK_UP
    return api;
}

}  // namespace

const core::Result<OpenClApi>& opencl_api() {
    asked_for_opencl.store(true, std::memory_order_relaxed);
    static const core::Result<OpenClApi> api = open_opencl();
    return api;
}

bool opencl_was_asked_for() {
    return asked_for_opencl.load(std::memory_order_relaxed);
}

std::string opencl_error(cl_int code) {
    static constexpr std::pair<cl_int, const char*> kNames[] = {
        {CL_DEVICE_NOT_FOUND, "CL_DEVICE_NOT_FOUND"},
        {CL_DEVICE_NOT_AVAILABLE, "CL_DEVICE_NOT_AVAILABLE"},
        {CL_COMPILER_NOT_AVAILABLE, "CL_COMPILER_NOT_AVAILABLE"},
        {CL_MEM_OBJECT_ALLOCATION_FAILURE, "CL_MEM_OBJECT_ALLOCATION_FAILURE"},
        {CL_OUT_OF_RESOURCES, "CL_OUT_OF_RESOURCES"},
        {CL_OUT_OF_HOST_MEMORY, "CL_OUT_OF_HOST_MEMORY"},
        {CL_BUILD_PROGRAM_FAILURE, "CL_BUILD_PROGRAM_FAILURE"},
        {CL_MAP_FAILURE, "CL_MAP_FAILURE"},
        {CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST,
         "CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST"},
        {CL_INVALID_VALUE, "CL_INVALID_VALUE"},
        {CL_INVALID_BINARY, "CL_INVALID_BINARY"},
        {CL_INVALID_BUILD_OPTIONS, "CL_INVALID_BUILD_OPTIONS"},
        {CL_INVALID_KERNEL_NAME, "CL_INVALID_KERNEL_NAME"},
        {CL_INVALID_KERNEL_ARGS, "CL_INVALID_KERNEL_ARGS"},
        {CL_INVALID_ARG_SIZE, "CL_INVALID_ARG_SIZE"},
        {CL_INVALID_WORK_GROUP_SIZE, "CL_INVALID_WORK_GROUP_SIZE"},
        {CL_INVALID_BUFFER_SIZE, "CL_INVALID_BUFFER_SIZE"},
        {-1001, "CL_PLATFORM_NOT_FOUND_KHR"},
    };
    for (const auto& [known, name] : kNames) {
        if (known == code) {
            return std::string(name) + " (" + std::to_string(code) + ")";
        }
    }
    return std::to_string(code);
}

}  // namespace zoned::compute
