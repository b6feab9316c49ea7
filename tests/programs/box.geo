// A box for Gmsh, in perspective.
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
General.Orthographic = 0;
