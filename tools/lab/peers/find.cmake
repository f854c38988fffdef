# Finds the other libraries of benchmarks and of the league, all optional.
find_package(embree 3 QUIET)
find_package(TBB QUIET) # used by Embree
if(embree_FOUND AND TBB_FOUND)
  set(embree_usable TRUE)
endif()

# CGAL's CMake package requires more than these headers need, and Bullet's package has no targets. The trees' exact
# predicates fall back on GMP and MPFR.
find_path(CGAL_INCLUDE_DIR CGAL/AABB_tree.h)
find_library(GMP_LIBRARY gmp)
find_library(MPFR_LIBRARY mpfr)
if(CGAL_INCLUDE_DIR AND GMP_LIBRARY AND MPFR_LIBRARY)
  set(cgal_usable TRUE)
endif()

pkg_check_modules(BULLET QUIET IMPORTED_TARGET bullet)

pkg_check_modules(PEER_ODE QUIET IMPORTED_TARGET ode)
find_library(MUJOCO_LIBRARY mujoco)
find_path(MUJOCO_INCLUDE_DIR mujoco/mujoco.h)
if(MUJOCO_LIBRARY AND MUJOCO_INCLUDE_DIR)
  set(mujoco_usable TRUE)
endif()
