export { default as always } from "./always.json";
export { default as common } from "./common.json";
export { default as goal } from "./goal.json";
export { default as modules } from "./modules.json";
export { default as ontology } from "./ontology.json";
export { default as scene3d } from "./scene3d.json";
export { default as task } from "./task.json";
export { default as world } from "./world.json";
