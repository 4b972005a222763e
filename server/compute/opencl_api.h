// OpenClApi: the functions of libOpenCL, looked up in the library on first use.
#pragma once

#include "shared/core/result.h"

#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

#include <string>

namespace zoned::compute {

/// Nothing links libOpenCL, so a process without work for a device maps neither it nor the drivers
/// behind it. OpenCL 1.2.
struct OpenClApi {
#define ZONED_OPENCL_FUNCTIONS(X) \
    X(clGetPlatformIDs)           \
    X(clGetPlatformInfo)          \
    X(clGetDeviceIDs)             \
    X(clGetDeviceInfo)            \
    X(clCreateContext)            \
    X(clReleaseContext)           \
    X(clCreateCommandQueue)       \
    X(clReleaseCommandQueue)      \
    X(clCreateBuffer)             \
    X(clReleaseMemObject)         \
    X(clCreateProgramWithSource)  \
    X(clCreateProgramWithBinary)  \
    X(clBuildProgram)             \
    X(clGetProgramInfo)           \
    X(clGetProgramBuildInfo)      \
    X(clReleaseProgram)           \
    X(clCreateKernel)             \
    X(clReleaseKernel)            \
    X(clSetKernelArg)             \
    X(clGetKernelWorkGroupInfo)   \
    X(clEnqueueNDRangeKernel)     \
    X(clEnqueueMapBuffer)         \
    X(clEnqueueUnmapMemObject)    \
    X(clEnqueueReadBufferRect)    \
    X(clEnqueueWriteBufferRect)   \
    X(clFinish)
#define ZONED_OPENCL_POINTER(name) decltype(&::name) name = nullptr;
    ZONED_OPENCL_FUNCTIONS(ZONED_OPENCL_POINTER)
#undef ZONED_OPENCL_POINTER
};

/// Opens libOpenCL.so.1 on the first call; later calls return the first result. Fails with the
/// loader's reason. Threads may call it at once.
const core::Result<OpenClApi>& opencl_api();

/// Whether opencl_api() was ever called in this process.
bool opencl_was_asked_for();

/// "CL_OUT_OF_RESOURCES (-5)"; a number alone where the name is not known.
std::string opencl_error(cl_int code);

}  // namespace zoned::compute
