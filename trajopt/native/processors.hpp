// A wheel must run everywhere, and the wide registers of newer processors halve the time: functions are compiled
// for several of them and chosen when the module is loaded, or when they are called.
#pragma once

#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__)
#define SEVERAL_PROCESSORS
#define FOR_SEVERAL_PROCESSORS __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define FOR_SEVERAL_PROCESSORS
#endif
